function p = dotb(q, omega)
% DOTB  Rate of a unit quaternion whose frame turns at omega, in its own frame.
  p = quaternion(mjsim_product(q.rows, [0, omega(:)']) / 2);
end
