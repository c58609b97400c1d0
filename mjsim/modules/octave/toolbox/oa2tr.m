function T = oa2tr(o, a)
% OA2TR  Pose in the origin whose y axis is near o and whose z axis is along a.
  T = r2t(oa2r(o, a));
end
