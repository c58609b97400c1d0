function answer = islimit(varargin)
% ISLIMIT  For each joint -1 below its lower limit, 1 above its upper one, else 0: islimit(r, q).
  [r, rest] = mjsim_robot(varargin);
  bounds = r.qlim; q = rest{1}(:);
  answer = (q > bounds(:, 2)) - (q < bounds(:, 1));
end
