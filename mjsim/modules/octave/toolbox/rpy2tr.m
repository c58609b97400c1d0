function T = rpy2tr(varargin)
% RPY2TR  The pose of roll, pitch and yaw: Rz(roll) Ry(pitch) Rx(yaw), as the old toolbox has them; Rx Ry Rz with 'xyz'.
  a = mjsim_deg(varargin);
  if any(strcmp(varargin, 'xyz'))
    T = trotx(a(3)) * troty(a(2)) * trotz(a(1));
  else
    T = trotz(a(1)) * troty(a(2)) * trotx(a(3));
  end
end
