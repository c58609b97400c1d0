function a = jacob_dot(varargin)
% JACOB_DOT  The product of the Jacobian's rate and joint rates, 6 x 1: jacob_dot(r, q, qd); the tool's acceleration is
%   jacob0(r, q) * qdd + this.
  [r, rest] = mjsim_robot(varargin);
  c = mjsim_chain(r); q = rest{1}(:)'; qd = rest{2}(:)'; h = 1e-3 / max(1, norm(qd));
  at = @(k) mjsim_jacobian(c, q + k * h * qd);
  % Central differences of the fourth order.
  a = (8 * (at(1) - at(-1)) - (at(2) - at(-2))) / (12 * h) * qd';
end
