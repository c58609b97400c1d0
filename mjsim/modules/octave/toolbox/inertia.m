function M = inertia(varargin)
% INERTIA  The mass matrix with rotors, n x n, or n x n x k for q with k rows: inertia(r, q).
  [r, rest] = mjsim_robot(varargin);
  s = mjsim_chain(r);
  n = numel(s.m);
  q = mjsim_rows(rest{1}, n);
  M = zeros(n, n, size(q, 1));
  for k = 1:size(q, 1)
    [~, rigid] = mjsim_rne(s, q(k, :), zeros(1, n), zeros(1, n), zeros(3, 1), zeros(6, 1), 0);
    M(:, :, k) = (rigid + rigid') / 2 + diag(s.G.^2 .* s.Jm);
  end
end
