function qdd = accel(varargin)
% ACCEL  Accelerations of the joints under torques: accel(r, q, qd, tau).
  [r, rest] = mjsim_robot(varargin);
  q = rest{1}(:)'; qd = rest{2}(:)'; tau = rest{3}(:)';
  qdd = inertia(r, q) \ (tau - rne(r, q, qd, zeros(size(q))))';
end
