function T = rpy2tr(roll, pitch, yaw)
% RPY2TR  The pose of roll, pitch and yaw: Rz(roll) Ry(pitch) Rx(yaw), as the old toolbox has them.
  if nargin == 1, [roll, pitch, yaw] = deal(roll(1), roll(2), roll(3)); end
  T = trotz(roll) * troty(pitch) * trotx(yaw);
end
