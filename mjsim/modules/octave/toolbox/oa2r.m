function R = oa2r(o, a)
% OA2R  Rotation whose y axis is near o and whose z axis is along a.
  a = unit(a(:)); n = unit(cross(o(:), a));
  R = [n cross(a, n) a];
end
