function p = minus(a, b)
% MINUS  Difference of the parts.
  p = quaternion(a.rows - b.rows);
end
