function T = trinterp(T0, T1, s)
% TRINTERP  The pose at a fraction s of the way between two poses.
  R = T0(1:3, 1:3)' * T1(1:3, 1:3);
  v = [R(3, 2) - R(2, 3); R(1, 3) - R(3, 1); R(2, 1) - R(1, 2)] / 2;
  sine = norm(v); cosine = (trace(R) - 1) / 2;
  angle = atan2(sine, cosine);
  if sine < 1e-12 && cosine < 0
    [unused, k] = max(diag(R)); v = R(:, k) + (1:3 == k)'; sine = norm(v);
  end
  turn = eye(3);
  if sine > 0
    u = v / sine;
    K = [0 -u(3) u(2); u(3) 0 -u(1); -u(2) u(1) 0];
    turn = eye(3) + sin(s * angle) * K + (1 - cos(s * angle)) * K * K;
  end
  T = [T0(1:3, 1:3) * turn, T0(1:3, 4) + s * (T1(1:3, 4) - T0(1:3, 4)); 0 0 0 1];
end
