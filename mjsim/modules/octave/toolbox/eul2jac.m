function J = eul2jac(phi, theta, psi_)
% EUL2JAC  Matrix from rates of ZYZ angles to the angular velocity: eul2jac(phi, theta, psi) or of a vector.
  if nargin < 3, psi_ = phi(3); theta = phi(2); phi = phi(1); end
  a = [0; 0; 1]; b = [-sin(phi); cos(phi); 0];
  J = [a b [cos(phi) * sin(theta); sin(phi) * sin(theta); cos(theta)]];
end
