function n = norm(q)
% NORM  Length of each.
  n = sqrt(sum(q.rows .^ 2, 2));
end
