function T = rpy2tr(varargin)
% RPY2TR  The pose of roll, pitch and yaw: Rz(roll) Ry(pitch) Rx(yaw), as the old toolbox has them.
  a = mjsim_deg(varargin);
  T = trotz(a(1)) * troty(a(2)) * trotx(a(3));
end
