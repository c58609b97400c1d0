function J = rpy2jac(r, p, y)
% RPY2JAC  Matrix from rates of roll, pitch and yaw to the angular velocity: rpy2jac(r, p, y) or of a vector.
  if nargin < 3, y = r(3); p = r(2); r = r(1); end
  step = 1e-6; J = zeros(3);
  for k = 1:3
    d = step * (1:3 == k);
    ahead = rpy2r(r + d(1), p + d(2), y + d(3)); back = rpy2r(r - d(1), p - d(2), y - d(3));
    J(:, k) = vex((ahead - back) / (2 * step) * rpy2r(r, p, y)');
  end
end
