function tau = gravload(varargin)
% GRAVLOAD  Torques that hold an arm, a row for each row of q: gravload(r, q, gravity).
  [r, rest] = mjsim_robot(varargin);
  s = mjsim_chain(r);
  q = mjsim_rows(rest{1}, numel(s.m));
  gravity = s.gravity;
  if numel(rest) > 1 && ~isempty(rest{2}), gravity = rest{2}; end
  none = zeros(1, size(q, 2));
  tau = zeros(size(q));
  for k = 1:size(q, 1)
    tau(k, :) = mjsim_rne(s, q(k, :), none, none, gravity, zeros(6, 1), 0);
  end
end
