function T = angvec2tr(angle, axis)
% ANGVEC2TR  The pose of a rotation by an angle about an axis.
  T = [angvec2r(angle, axis), zeros(3, 1); 0 0 0 1];
end
