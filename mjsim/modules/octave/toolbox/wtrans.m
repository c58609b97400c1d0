function w = wtrans(T, w)
% WTRANS  Force and moment in the frame of a pose T: wtrans(T, w).
  R = T(1:3, 1:3)'; f = w(1:3); m = w(4:6);
  w = reshape([R * f(:); R * (m(:) + cross(f(:), T(1:3, 4)))], size(w));
end
