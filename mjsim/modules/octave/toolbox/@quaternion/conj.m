function p = conj(q)
% CONJ  Conjugate.
  p = quaternion(q.rows .* [1 -1 -1 -1]);
end
