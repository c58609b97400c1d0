function qdd = accel(varargin)
% ACCEL  Accelerations of the joints under torques: accel(r, q, qd, tau) or accel(r, [q qd tau]).
%   A column for one posture, a row for each of several.
  [r, rest] = mjsim_robot(varargin);
  s = mjsim_chain(r);
  n = numel(s.m);
  if numel(rest) == 1
    x = mjsim_rows(rest{1}, 3 * n);
    rest = {x(:, 1:n), x(:, n + 1:2 * n), x(:, 2 * n + 1:end)};
  end
  q = mjsim_rows(rest{1}, n); qd = mjsim_rows(rest{2}, n); tau = mjsim_rows(rest{3}, n);
  qdd = zeros(size(q));
  for k = 1:size(q, 1)
    [bias, M] = mjsim_rne(s, q(k, :), qd(k, :), zeros(1, n), s.gravity, zeros(6, 1), 1);
    qdd(k, :) = (M + diag(s.G.^2 .* s.Jm)) \ (tau(k, :) - bias)';
  end
  if size(q, 1) == 1, qdd = qdd'; end
end
