function p = normalize(q)
% NORMALIZE  Quaternion of length 1.
  p = quaternion(q.rows ./ norm(q));
end
