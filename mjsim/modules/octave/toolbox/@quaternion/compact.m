function rows = compact(q)
% COMPACT  Numbers [w x y z], a row for each.
  rows = q.rows;
end
