function q = homtrans(T, p)
% HOMTRANS  Points moved by a pose, a column each: homtrans(T, p); or poses, 4 x 4 x k.
  if size(p, 1) == rows(T)
    q = p;
    for k = 1:size(p, 3), q(:, :, k) = T * p(:, :, k); end
  else
    q = h2e(T * e2h(p));
  end
end
