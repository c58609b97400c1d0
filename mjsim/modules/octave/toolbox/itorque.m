function tau = itorque(varargin)
% ITORQUE  Torques that accelerate an arm at rest, without gravity, a row for each row of q: itorque(r, q, qdd).
  [r, rest] = mjsim_robot(varargin);
  tau = rne(r, rest{1}, zeros(size(rest{1})), rest{2}, [0 0 0]);
end
