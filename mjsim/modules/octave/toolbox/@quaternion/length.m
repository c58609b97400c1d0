function n = length(q)
% LENGTH  How many there are.
  n = size(q.rows, 1);
end
