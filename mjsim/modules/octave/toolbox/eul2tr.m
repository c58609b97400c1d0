function T = eul2tr(varargin)
% EUL2TR  The pose of Euler's angles Rz(phi) Ry(theta) Rz(psi).
  a = mjsim_deg(varargin);
  T = trotz(a(1)) * troty(a(2)) * trotz(a(3));
end
