function S = trlog(T)
% TRLOG  Logarithm of a pose or rotation, a skew matrix: trexp(trlog(T)) is T.
  [angle, axis_] = tr2angvec(T(1:3, 1:3));
  W = skew(axis_(:) * angle);
  if rows(T) == 3, S = W; return, end
  V = eye(3);
  if abs(angle) > 1e-12
    K = W / angle;
    V = eye(3) + (1 - cos(angle)) / angle * K + (1 - sin(angle) / angle) * K^2;
  end
  S = [W V \ T(1:3, 4); zeros(1, 4)];
end
