function [angle, axis] = tr2angvec(T)
% TR2ANGVEC  Angle from 0 to pi and axis, 1 x 3, of a pose or a rotation; the axis of no rotation is 0.
  R = T(1:3, 1:3);
  v = vex(R)';
  angle = atan2(norm(v), (trace(R) - 1) / 2);
  if norm(v) > 1e-8
    axis = v / norm(v);
  else
    [V, D] = eig((R + R') / 2);
    [unused, k] = max(diag(D));
    axis = (angle > 1) * V(:, k)';
  end
end
