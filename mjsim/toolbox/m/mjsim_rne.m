function tau = mjsim_rne(s, q, qd, qdd, gravity, fext, motors)
% MJSIM_RNE  Torques by Newton and Euler's equations in the frame of the world, 1 x n.
%   fext: force and moment that the tool exerts, in its own frame; motors: rotors and friction counted (1) or not (0).
  frames = mjsim_frames(s, q);
  n = numel(s.links);
  w = zeros(3, 1); wd = w; a = gravity(:); o = s.base(1:3, 4);
  F = zeros(3, n); N = F; axes = F; points = F;
  before = s.base;
  for k = 1:n
    l = s.links(k);
    T = frames(:, :, k);
    if l.mdh, axis = T; else, axis = before; end
    z = axis(1:3, 3);
    axes(:, k) = z; points(:, k) = axis(1:3, 4);
    d = T(1:3, 4) - o;
    if l.sigma
      a = a + cross(wd, d) + cross(w, cross(w, d)) + z * qdd(k) + 2 * cross(w, z * qd(k));
    elseif l.mdh
      a = a + cross(wd, d) + cross(w, cross(w, d));
      wd = wd + z * qdd(k) + cross(w, z * qd(k));
      w = w + z * qd(k);
    else
      wd = wd + z * qdd(k) + cross(w, z * qd(k));
      w = w + z * qd(k);
      a = a + cross(wd, d) + cross(w, cross(w, d));
    end
    o = T(1:3, 4);
    R = T(1:3, 1:3);
    c = R * l.r(:);
    F(:, k) = l.m * (a + cross(wd, c) + cross(w, cross(w, c)));
    I = R * l.I * R';
    N(:, k) = I * wd + cross(w, I * w) + cross(o + c, F(:, k));
    before = T;
  end
  tool = frames(:, :, n) * s.tool;
  f = tool(1:3, 1:3) * fext(1:3)(:);
  m = tool(1:3, 1:3) * fext(4:6)(:) + cross(tool(1:3, 4), f);
  tau = zeros(1, n);
  for k = n:-1:1
    l = s.links(k);
    f = f + F(:, k); m = m + N(:, k);
    if l.sigma
      tau(k) = axes(:, k)' * f;
    else
      tau(k) = axes(:, k)' * (m - cross(points(:, k), f));
    end
    if motors
      tau(k) = tau(k) + l.G^2 * l.Jm * qdd(k) + l.G^2 * l.B * qd(k);
      if qd(k) > 0, tau(k) = tau(k) + abs(l.G) * l.Tc(1); end
      if qd(k) < 0, tau(k) = tau(k) + abs(l.G) * l.Tc(2); end
    end
  end
end
