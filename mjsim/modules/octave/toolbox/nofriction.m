function r = nofriction(r, what)
% NOFRICTION  The arm without dry friction: nofriction(r); also without viscous friction: nofriction(r, 'all').
  for k = 1:r.n
    r.links(k).Tc = [0 0];
    if nargin > 1 && strcmp(what, 'all'), r.links(k).B = 0; end
  end
end
