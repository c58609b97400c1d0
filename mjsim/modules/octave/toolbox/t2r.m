function R = t2r(T)
% T2R  The rotation of a pose.
  R = T(1:3, 1:3, :);
end
