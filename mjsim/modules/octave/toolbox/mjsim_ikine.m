function [q, miss] = mjsim_ikine(s, T, q0, M)
% MJSIM_IKINE  Damped least squares from q0, then from other starts, always the same ones (Sugihara, 2011).
  n = numel(s.m);
  best = q0; least = Inf; again = 0;
  seed = 1;
  for try_ = 1:40
    start = q0;
    if try_ > 1
      for k = 1:n
        seed = mod(16807 * seed, 2147483647);
        start(k) = q0(k) + (2 * seed / 2147483647 - 1) * pi * (1 - 0.9 * s.slide(k));
      end
    end
    [q, miss] = descend(s, T, start, M);
    % Where several starts end at the same distance, that is the nearest.
    again = again + 1;
    if miss < least * (1 - 1e-4), again = 0; elseif miss > least * (1 + 1e-4), again = again - 1; end
    if miss < least
      best = q; least = miss;
    end
    if least < 1e-10 || again > 3, break, end
  end
  q = best; miss = least;
end

function [q, miss] = descend(s, T, q, M)
  n = numel(q);
  [e, J] = difference(s, T, q, M);
  damping = 1e-2;
  for step = 1:100
    if norm(e) < 1e-12, break, end
    E = e' * e;
    dq = (J' * J + (damping * E + 1e-14) * eye(n)) \ (J' * e);
    [e2, J2] = difference(s, T, q + dq', M);
    if e2' * e2 < E
      gain = 1 - (e2' * e2) / E;
      q = q + dq'; e = e2; J = J2; damping = max(damping / 4, 1e-6);
      if gain < 1e-12, break, end
    else
      damping = damping * 8;
      if damping > 1e12, break, end
    end
  end
  miss = norm(e);
end

function [e, J] = difference(s, T, q, M)
  [J, pose] = mjsim_jacobian(s, q);
  R = T(1:3, 1:3) * pose(1:3, 1:3)';
  v = [R(3, 2) - R(2, 3); R(1, 3) - R(3, 1); R(2, 1) - R(1, 2)] / 2;
  sine = norm(v); cosine = (trace(R) - 1) / 2;
  if sine > 1e-12
    v = v * (atan2(sine, cosine) / sine);
  elseif cosine < 0
    [unused, k] = max(diag(R));
    u = R(:, k) + (1:3 == k)';
    v = pi * u / norm(u);
  end
  e = M .* [T(1:3, 4) - pose(1:3, 4); v];
  J = M .* J;
end
