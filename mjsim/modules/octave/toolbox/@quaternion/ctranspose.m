function p = ctranspose(q)
% CTRANSPOSE  Conjugate, q'.
  p = conj(q);
end
