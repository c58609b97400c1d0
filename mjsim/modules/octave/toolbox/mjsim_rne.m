function tau = mjsim_rne(c, q, qd, qdd, gravity, fext, motors)
% MJSIM_RNE  Torques by Newton and Euler's equations in the frame of the world, 1 x n, of a chain.
%   fext: force and moment that the tool exerts, in its own frame; motors: rotors and friction counted (1) or not (0).
  [T, J] = mjsim_frames(c, q);
  n = numel(c.m);
  w = zeros(3, n); wd = w; a = w; F = w; N = w;
  for k = 1:n
    p = c.parent(k);
    if p > 0
      [w0, wd0, a0, o0] = deal(w(:, p), wd(:, p), a(:, p), T(1:3, 4, p));
    else
      [w0, wd0, a0, o0] = deal(zeros(3, 1), zeros(3, 1), gravity(:), c.base(1:3, 4));
    end
    z = J(1:3, 3, k); o = T(1:3, 4, k);
    if c.slide(k)
      w(:, k) = w0; wd(:, k) = wd0;
      a(:, k) = a0 + swing(wd0, w0, o - o0) + z * qdd(k) + 2 * cross(w0, z * qd(k));
    else
      w(:, k) = w0 + z * qd(k);
      wd(:, k) = wd0 + z * qdd(k) + cross(w0, z * qd(k));
      b = J(1:3, 4, k);
      a(:, k) = a0 + swing(wd0, w0, b - o0) + swing(wd(:, k), w(:, k), o - b);
    end
    R = T(1:3, 1:3, k);
    s = R * c.r(:, k);
    F(:, k) = c.m(k) * (a(:, k) + swing(wd(:, k), w(:, k), s));
    I = R * c.I(:, :, k) * R';
    N(:, k) = I * wd(:, k) + cross(w(:, k), I * w(:, k)) + cross(o + s, F(:, k));
  end
  tool = T(:, :, c.carrier) * c.tool;
  f = tool(1:3, 1:3) * fext(1:3)(:);
  F(:, c.carrier) = F(:, c.carrier) + f;
  N(:, c.carrier) = N(:, c.carrier) + tool(1:3, 1:3) * fext(4:6)(:) + cross(tool(1:3, 4), f);
  tau = zeros(1, n);
  for k = n:-1:1
    if c.slide(k)
      tau(k) = J(1:3, 3, k)' * F(:, k);
    else
      tau(k) = J(1:3, 3, k)' * (N(:, k) - cross(J(1:3, 4, k), F(:, k)));
    end
    p = c.parent(k);
    if p > 0
      F(:, p) = F(:, p) + F(:, k); N(:, p) = N(:, p) + N(:, k);
    end
  end
  if motors
    tau = tau + c.G.^2 .* (c.Jm .* qdd(:)' + c.B .* qd(:)');
    tau = tau + abs(c.G) .* (c.Tc(1, :) .* (qd(:)' > 0) + c.Tc(2, :) .* (qd(:)' < 0));
  end
end

function a = swing(wd, w, d)
  a = cross(wd, d) + cross(w, cross(w, d));
end
