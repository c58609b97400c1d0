function T = rt2tr(R, t)
% RT2TR  Pose of a rotation and a position: rt2tr(R, t), in space or in the plane.
  T = [R t(:); zeros(1, rows(R)) 1];
end
