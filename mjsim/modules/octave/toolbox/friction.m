function tau = friction(varargin)
% FRICTION  Torques of friction, against the motion, for rates of the joints: friction(r, qd).
  [r, rest] = mjsim_robot(varargin);
  s = mjsim_chain(r);
  qd = mjsim_rows(rest{1}, numel(s.m));
  tau = -s.G .^ 2 .* s.B .* qd - abs(s.G) .* (s.Tc(1, :) .* (qd > 0) + s.Tc(2, :) .* (qd < 0));
end
