function T = delta2tr(d)
% DELTA2TR  The pose of a small motion [dx dy dz rx ry rz].
  T = eye(4) + [skew(d(4:6)), reshape(d(1:3), 3, 1); 0 0 0 0];
end
