function p = slerp(a, b, r, way)
% SLERP  From a (r = 0) to b (r = 1) on the shorter way, a row for each r.
  d = mjsim_product(a.rows(1, :) .* [1 -1 -1 -1], b.rows(1, :)) / norm(a)(1) ^ 2;
  if d(1) < 0 && nargin < 4, d = -d; end
  s = norm(d(2:4)); angles = atan2(s, d(1)) * r(:);
  p = quaternion(mjsim_product(a.rows(1, :), [cos(angles), sin(angles) * d(2:4) / max(s, realmin)]));
end
