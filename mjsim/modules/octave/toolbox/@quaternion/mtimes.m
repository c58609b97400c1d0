function p = mtimes(a, b)
% MTIMES  Product of quaternions, or with a scalar; q * v, v 3 x n, turns vectors.
  if isnumeric(a), p = quaternion(a .* b.rows);
  elseif isobject(b), p = quaternion(mjsim_product(a.rows, b.rows));
  elseif isscalar(b), p = quaternion(a.rows * b);
  else, p = rotmat(a, 'point') * b;
  end
end
