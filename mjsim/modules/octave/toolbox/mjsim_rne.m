function [tau, M, W] = mjsim_rne(c, q, qd, qdd, gravity, fext, motors)
% MJSIM_RNE  Torques by Newton and Euler's equations, 1 x n, of a chain, its mass matrix without rotors, and the force
%   and moment on its base, 1 x 6, in the frame of the base.
%   fext: force and moment that the tool exerts, in its own frame; motors: rotors and friction counted (1) or not (0).
%   Spatial vectors, rotation first, about the origin of the base (Featherstone 2008, chapters 2 and 5).
  [T, J] = mjsim_frames(c, q);
  n = numel(c.m);
  origin = c.base(1:3, 4);
  A = zeros(6 * n, n); F = zeros(6 * n, 1); H = A; v = zeros(6, n); a = v;
  for k = 1:n
    rows = 6 * k - 5:6 * k;
    p = c.parent(k);
    if p > 0
      A(rows, :) = A(6 * p - 5:6 * p, :);
      v0 = v(:, p); a0 = a(:, p);
    else
      v0 = zeros(6, 1); a0 = [0; 0; 0; gravity(:)];
    end
    z = J(1:3, 3, k); b = J(1:3, 4, k) - origin;
    if c.slide(k)
      s = [0; 0; 0; z];
    else
      s = [z; b(2) * z(3) - b(3) * z(2); b(3) * z(1) - b(1) * z(3); b(1) * z(2) - b(2) * z(1)];
    end
    A(rows, k) = s;
    w = v0 + s * qd(k);
    W = [0 -w(3) w(2) 0 0 0; w(3) 0 -w(1) 0 0 0; -w(2) w(1) 0 0 0 0; ...
         0 -w(6) w(5) 0 -w(3) w(2); w(6) 0 -w(4) w(3) 0 -w(1); -w(5) w(4) 0 -w(2) w(1) 0];
    v(:, k) = w;
    a(:, k) = a0 + s * qdd(k) + W * (s * qd(k));
    R = T(1:3, 1:3, k); m = c.m(k);
    h = R * c.r(:, k) + T(1:3, 4, k) - origin;
    X = [0 -h(3) h(2); h(3) 0 -h(1); -h(2) h(1) 0];
    I = [R * c.I(:, :, k) * R' - m * X * X, m * X; -m * X, m * eye(3)];
    F(rows) = I * a(:, k) - W' * (I * w);
    H(rows, :) = I * A(rows, :);
  end
  tool = T(:, :, c.carrier) * c.tool;
  f = tool(1:3, 1:3) * fext(1:3)(:); x = tool(1:3, 4) - origin;
  rows = 6 * c.carrier - 5:6 * c.carrier;
  F(rows) = F(rows) + [tool(1:3, 1:3) * fext(4:6)(:) + cross(x, f); f];
  tau = (A' * F)';
  M = A' * H;
  W = sum(reshape(F, 6, n), 2);
  W = reshape(c.base(1:3, 1:3)' * [W(4:6), W(1:3)], 1, 6);
  if motors
    tau = tau + c.G.^2 .* (c.Jm .* qdd(:)' + c.B .* qd(:)');
    tau = tau + abs(c.G) .* (c.Tc(1, :) .* (qd(:)' > 0) + c.Tc(2, :) .* (qd(:)' < 0));
  end
end
