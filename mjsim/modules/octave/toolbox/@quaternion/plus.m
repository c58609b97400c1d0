function p = plus(a, b)
% PLUS  Sum of the parts.
  p = quaternion(a.rows + b.rows);
end
