function T = eul2tr(phi, theta, psi)
% EUL2TR  The pose of Euler's angles Rz(phi) Ry(theta) Rz(psi).
  if nargin == 1, [phi, theta, psi] = deal(phi(1), phi(2), phi(3)); end
  T = trotz(phi) * troty(theta) * trotz(psi);
end
