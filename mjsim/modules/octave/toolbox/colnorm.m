function n = colnorm(m)
% COLNORM  Lengths of columns.
  n = sqrt(sum(m.^2, 1));
end
