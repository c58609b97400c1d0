function l = mjsim_link(L)
% MJSIM_LINK  One form of both kinds of links.
  l = struct('theta', L.theta, 'd', 0, 'a', 0, 'alpha', L.alpha, 'sigma', L.sigma, 'offset', L.offset, ...
             'mdh', L.mdh, 'm', L.m, 'r', L.r(:)', 'I', mjsim_inertia(L.I), 'Jm', L.Jm, 'G', L.G, 'B', L.B, ...
             'Tc', L.Tc, 'qlim', L.qlim);
  if isfield(L, 'A')
    l.a = L.A; l.d = L.D;
  else
    l.a = L.a; l.d = L.d;
  end
  if isempty(l.G) || l.G == 0, l.G = 1; end
  if numel(l.Tc) == 1, l.Tc = [l.Tc, -l.Tc]; end
end
