function C = coriolis(varargin)
% CORIOLIS  The matrix of Christoffel symbols, C * qd' are the torques of Coriolis and centrifugal forces.
  [r, rest] = mjsim_robot(varargin);
  s = mjsim_chain(r);
  n = numel(s.m);
  q = rest{1}(:)'; qd = rest{2}(:)';
  none = zeros(1, n);
  C = zeros(n);
  square = @(v) mjsim_rne(s, q, v, none, zeros(3, 1), zeros(6, 1), 0)';
  for j = 1:n
    unit = none; unit(j) = 1;
    C(:, j) = square((qd + unit) / 2) - square((qd - unit) / 2);
  end
end
