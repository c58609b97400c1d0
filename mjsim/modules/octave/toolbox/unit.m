function u = unit(v)
% UNIT  Vector of length 1 along v.
  u = v / norm(v);
end
