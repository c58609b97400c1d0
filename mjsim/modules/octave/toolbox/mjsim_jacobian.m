function [J, T] = mjsim_jacobian(c, q)
% MJSIM_JACOBIAN  The Jacobian of the tool in the world, 6 x n, and its pose, of a chain.
  [frames, joints] = mjsim_frames(c, q);
  T = frames(:, :, c.carrier) * c.tool;
  J = zeros(6, numel(c.m));
  k = c.carrier;
  while k > 0
    z = joints(1:3, 3, k);
    if c.slide(k)
      J(:, k) = [z; 0; 0; 0];
    else
      J(:, k) = [cross(z, T(1:3, 4) - joints(1:3, 4, k)); z];
    end
    k = c.parent(k);
  end
end
