function [J, T] = mjsim_jacobian(s, q)
% MJSIM_JACOBIAN  The Jacobian of the tool in the world, 6 x n, and its pose.
  frames = mjsim_frames(s, q);
  n = numel(s.links);
  T = frames(:, :, n) * s.tool;
  J = zeros(6, n);
  before = s.base;
  for k = 1:n
    if s.links(k).mdh, axis = frames(:, :, k); else, axis = before; end
    z = axis(1:3, 3);
    if s.links(k).sigma
      J(:, k) = [z; 0; 0; 0];
    else
      J(:, k) = [cross(z, T(1:3, 4) - axis(1:3, 4)); z];
    end
    before = frames(:, :, k);
  end
end
