function T = trnorm(T)
% TRNORM  The pose or rotation with axes that are exactly orthogonal; the third axis keeps its direction.
  a = unit(T(1:3, 3)); n = unit(cross(T(1:3, 2), a));
  T(1:3, 1:3) = [n cross(a, n) a];
end
