function n = numrows(m)
% NUMROWS  Number of rows.
  n = size(m, 1);
end
