function [T, links] = mjsim_frames(s, q)
% MJSIM_FRAMES  Poses of all links in the world, 4 x 4 x n, of an arm as a struct.
  links = s.links;
  n = numel(links);
  T = zeros(4, 4, n);
  pose = s.base;
  for k = 1:n
    l = links(k);
    theta = q(k) + l.offset; d = l.d;
    if l.sigma
      theta = l.theta; d = q(k) + l.offset;
    end
    ct = cos(theta); st = sin(theta); ca = cos(l.alpha); sa = sin(l.alpha);
    if l.mdh
      A = [ct -st 0 l.a; st*ca ct*ca -sa -sa*d; st*sa ct*sa ca ca*d; 0 0 0 1];
    else
      A = [ct -st*ca st*sa l.a*ct; st ct*ca -ct*sa l.a*st; 0 sa ca d; 0 0 0 1];
    end
    pose = pose * A;
    T(:, :, k) = pose;
  end
end
