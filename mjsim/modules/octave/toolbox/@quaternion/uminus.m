function p = uminus(q)
% UMINUS  All parts negative: the same rotation.
  p = quaternion(-q.rows);
end
