function [T, J] = mjsim_frames(c, q)
% MJSIM_FRAMES  Poses of all links and of all joints in the world, 4 x 4 x n each, of a chain.
  n = numel(c.m);
  T = zeros(4, 4, n); J = T;
  for k = 1:n
    pose = c.base;
    if c.parent(k) > 0, pose = T(:, :, c.parent(k)); end
    J(:, :, k) = pose * c.before(:, :, k);
    v = q(k) + c.offset(k);
    if c.slide(k)
      move = [1 0 0 0; 0 1 0 0; 0 0 1 v; 0 0 0 1];
    else
      move = [cos(v) -sin(v) 0 0; sin(v) cos(v) 0 0; 0 0 1 0; 0 0 0 1];
    end
    T(:, :, k) = J(:, :, k) * move * c.after(:, :, k);
  end
end
