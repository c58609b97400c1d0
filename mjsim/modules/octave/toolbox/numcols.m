function n = numcols(m)
% NUMCOLS  Number of columns.
  n = size(m, 2);
end
