function r = payload(r, m, p)
% PAYLOAD  Adds a point mass m at p in the frame of the last link: payload(r, m, p), or r = payload(r, m, p).
  if nargin < 3, p = [0 0 0]; end
  links = r.links; l = links(end);
  place = l.r(:) ; p = p(:);
  if isempty(l.m), l.m = 0; end
  mass = l.m + m; centre = place;
  if mass > 0, centre = (l.m * place + m * p) / mass; end
  spread = @(d) d' * d * eye(3) - d * d';
  l.I = mjsim_inertia(l.I) + l.m * spread(place - centre) + m * spread(p - centre);
  l.m = mass; l.r = centre';
  links(end) = l;
  r.links = links;
  if nargout == 0
    name = inputname(1, false);
    if isempty(name), error('write r = payload(r, m, p)'); end
    assignin('caller', name, r);
    clear r
  end
end
