function p = times(a, b)
% TIMES  As mtimes: products of quaternions are by rows.
  p = mtimes(a, b);
end
