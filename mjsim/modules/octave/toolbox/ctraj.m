function T = ctraj(T0, T1, t)
% CTRAJ  Poses along a straight line, 4 x 4 x k: ctraj(T0, T1, k) with smooth speed, or for path positions in [0, 1].
  if isscalar(t)
    s = jtraj(0, 1, t);
  else
    s = t(:);
    if max(s) > 1 || min(s) < 0
      s = jtraj(0, 1, s);
    end
  end
  T = zeros(4, 4, numel(s));
  for k = 1:numel(s), T(:, :, k) = trinterp(T0, T1, s(k)); end
end
