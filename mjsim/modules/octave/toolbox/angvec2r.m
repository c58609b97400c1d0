function R = angvec2r(angle, axis)
% ANGVEC2R  The rotation by an angle about an axis (Rodrigues' formula).
  S = skew(axis / norm(axis));
  R = eye(3) + sin(angle) * S + (1 - cos(angle)) * S^2;
end
