function c = mjsim_chain(r)
% MJSIM_CHAIN  Geometry and masses of an arm: frames before and after each joint, as robot.arms.NAME has them.
  if isfield(r, 'Tc')
    c = r;
    return
  end
  if isstruct(r)
    c = struct('before', r.before, 'after', r.after, 'slide', r.slide(:)', 'parent', r.parents(:)' + 1, ...
               'carrier', r.carrier + 1, 'base', r.base, 'tool', r.tool, 'gravity', -r.gravity(:), 'm', r.mass(:)', ...
               'r', r.center, 'G', r.gear(:)', 'Jm', r.rotor_inertia(:)', 'B', r.viscous(:)', 'Tc', r.coulomb);
    c.I = zeros(3, 3, numel(c.m));
    for k = 1:numel(c.m), c.I(:, :, k) = mjsim_inertia(r.inertia(:, k)); end
    c.offset = zeros(size(c.m));
    return
  end
  s = mjsim_plain(r);
  n = numel(s.links);
  c = struct('before', repmat(eye(4), [1 1 n]), 'after', repmat(eye(4), [1 1 n]), 'slide', [s.links.sigma], ...
             'parent', 0:n - 1, 'carrier', n, 'base', s.base, 'tool', s.tool, 'gravity', s.gravity(:), ...
             'm', [s.links.m], 'r', zeros(3, n), 'G', [s.links.G], 'Jm', [s.links.Jm], 'B', [s.links.B], ...
             'Tc', zeros(2, n), 'I', zeros(3, 3, n), 'offset', [s.links.offset]);
  for k = 1:n
    l = s.links(k);
    c.r(:, k) = l.r; c.I(:, :, k) = l.I; c.Tc(:, k) = l.Tc;
    ca = cos(l.alpha); sa = sin(l.alpha);
    twist = [1 0 0 l.a; 0 ca -sa 0; 0 sa ca 0; 0 0 0 1];
    turn = eye(4);
    if l.sigma
      turn(1:2, 1:2) = [cos(l.theta) -sin(l.theta); sin(l.theta) cos(l.theta)];
    else
      turn(3, 4) = l.d;
    end
    if l.mdh
      c.before(:, :, k) = twist; c.after(:, :, k) = turn;
    else
      c.after(:, :, k) = turn * twist;
    end
  end
end
