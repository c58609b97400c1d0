function S = skew(v)
% SKEW  The skew-symmetric matrix of 3 numbers (S * w is the cross product), or of 1.
  if numel(v) == 1
    S = [0 -v; v 0];
  else
    S = [0 -v(3) v(2); v(3) 0 -v(1); -v(2) v(1) 0];
  end
end
