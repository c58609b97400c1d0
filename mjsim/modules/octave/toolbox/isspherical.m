function answer = isspherical(r)
% ISSPHERICAL  Whether the last three axes of an arm of the standard convention meet in a point.
  s = mjsim_plain(r); L = s.links(end - 2:end);
  answer = numel(s.links) >= 3 && norm([L(1:2).a L(2).d]) < 1e-9 && ~any([L.sigma]) ...
           && norm(abs([L(1:2).alpha]) - pi / 2) < 1e-9;
end
