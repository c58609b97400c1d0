function p = inv(q)
% INV  Inverse; of a unit quaternion its conjugate.
  p = quaternion(q.rows .* [1 -1 -1 -1] ./ sum(q.rows .^ 2, 2));
end
