function d = angdiff(a, b)
% ANGDIFF  Difference a - b of angles in [-pi, pi), or a alone brought there.
  if nargin > 1, a = a - b; end
  d = mod(a + pi, 2 * pi) - pi;
end
