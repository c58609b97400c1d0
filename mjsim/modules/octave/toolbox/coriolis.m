function C = coriolis(varargin)
% CORIOLIS  The matrix of Christoffel symbols, C * qd' are the torques of Coriolis and centrifugal forces; n x n x k for
%   q and qd with k rows.
  [r, rest] = mjsim_robot(varargin);
  s = mjsim_chain(r);
  n = numel(s.m);
  q = mjsim_rows(rest{1}, n); qd = mjsim_rows(rest{2}, n);
  if size(q, 1) > 1
    C = zeros(n, n, size(q, 1));
    for k = 1:size(q, 1), C(:, :, k) = coriolis(r, q(k, :), qd(k, :)); end
    return
  end
  none = zeros(1, n);
  C = zeros(n);
  square = @(v) mjsim_rne(s, q, v, none, zeros(3, 1), zeros(6, 1), 0)';
  for j = 1:n
    unit = none; unit(j) = 1;
    C(:, j) = square((qd + unit) / 2) - square((qd - unit) / 2);
  end
end
