function D = diff2tr(d)
% DIFF2TR  The matrix of a small motion [dx dy dz rx ry rz], 4 x 4: the change of a pose is D * T.
  D = delta2tr(d) - eye(4);
end
