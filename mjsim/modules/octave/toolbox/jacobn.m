function J = jacobn(varargin)
% JACOBN  The Jacobian of the tool in its own frame, 6 x n: jacobn(r, q).
  [r, rest] = mjsim_robot(varargin);
  [J, T] = mjsim_jacobian(mjsim_chain(r), rest{1});
  R = T(1:3, 1:3)';
  J = [R, zeros(3); zeros(3), R] * J;
end
