function p = dot(q, omega)
% DOT  Rate of a unit quaternion whose frame turns at omega, in the fixed frame; of two quaternions their inner product.
  if isa(omega, 'quaternion'), p = sum(q.rows .* omega.rows, 2); return, end
  p = quaternion(mjsim_product([0, omega(:)'], q.rows) / 2);
end
