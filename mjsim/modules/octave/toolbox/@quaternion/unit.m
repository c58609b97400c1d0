function p = unit(q)
% UNIT  Quaternion of length 1.
  p = quaternion(q.rows ./ norm(q));
end
