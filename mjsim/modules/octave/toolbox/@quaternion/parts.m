function [w, x, y, z] = parts(q)
% PARTS  The four parts, a column each.
  w = q.rows(:, 1); x = q.rows(:, 2); y = q.rows(:, 3); z = q.rows(:, 4);
end
