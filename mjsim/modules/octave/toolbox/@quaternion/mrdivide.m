function p = mrdivide(a, b)
% MRDIVIDE  a * inv(b), or by a number.
  if isobject(b), p = mtimes(a, inv(b)); else, p = quaternion(a.rows / b); end
end
