function rows = double(q)
% DOUBLE  Numbers [w x y z], a row for each.
  rows = q.rows;
end
