function same = eq(a, b)
% EQ  Whether all parts are equal.
  same = all(a.rows == b.rows, 2);
end
