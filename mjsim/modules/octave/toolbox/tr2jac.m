function J = tr2jac(T, varargin)
% TR2JAC  6 x 6 matrix that takes velocities in the frame before a pose T to the frame after it.
  R = T(1:3, 1:3)';
  J = [R, -R * skew(T(1:3, 4)); zeros(3), R];
  if nargin > 1 && strcmp(varargin{1}, 'samebody'), return, end
  J = [R zeros(3); zeros(3) R];
end
