function q = ikine6s(varargin)
% IKINE6S  Joint values of an arm with the geometry of the Puma, in closed form: ikine6s(r, T, 'lun').
%   l or r: the shoulder left or right; u or d: the elbow up or down; n or f: the wrist not flipped or flipped.
  [r, rest] = mjsim_robot(varargin);
  s = mjsim_plain(r); L = s.links;
  if numel(L) ~= 6 || any([L.sigma]) || any([L.mdh]) || norm([L.alpha] - [1 0 -1 1 -1 0] * pi / 2) > 1e-6 ...
     || norm([L([1 4 5 6]).a L(5).d]) > 1e-9
    error('ikine6s is for arms with the geometry of the Puma; use ikine');
  end
  letters = 'lun';
  if numel(rest) > 1, letters = rest{2}; end
  right = any(letters == 'r'); down = any(letters == 'd'); flipped = any(letters == 'f');
  T = rest{1}; q = zeros(size(T, 3), 6);
  for k = 1:size(T, 3)
    M = s.base \ T(:, :, k) / s.tool;
    q(k, :) = solved(M, L, 2 * right - 1, 1 - 2 * down, 1 - 2 * flipped) - [L.offset];
  end
end

function q = solved(M, L, side, elbow, wrist)
  p = M(1:3, 4) - L(6).d * M(1:3, 3) - [0; 0; L(1).d];
  Z = L(2).d + L(3).d; X = side * sqrt(max(p(1)^2 + p(2)^2 - Z^2, 0)); Y = p(3);
  a2 = L(2).a; a3 = L(3).a; d4 = L(4).d;
  cosine = (X^2 + Y^2 - a2^2 - a3^2 - d4^2) / (2 * a2 * hypot(a3, d4));
  if p(1)^2 + p(2)^2 < Z^2 - 1e-9 || abs(cosine) > 1 + 1e-9
    warning('mjsim:ikine', 'the arm does not reach this pose'); q = nan(1, 6); return
  end
  q = zeros(1, 6);
  q(1) = atan2(p(2), p(1)) - atan2(-Z, X);
  q(3) = -atan2(d4, a3) - side * elbow * acos(max(min(cosine, 1), -1));
  u = a2 + a3 * cos(q(3)) - d4 * sin(q(3)); v = a3 * sin(q(3)) + d4 * cos(q(3));
  q(2) = atan2(Y, X) - atan2(v, u);
  R = M(1:3, 1:3)' * t2r(trotz(q(1)) * trotx(pi / 2) * trotz(q(2) + q(3)) * trotx(-pi / 2));
  R = R';
  sine = hypot(R(1, 3), R(2, 3));
  q(5) = wrist * atan2(sine, R(3, 3));
  if sine > 1e-9
    q(4) = atan2(-wrist * R(2, 3), -wrist * R(1, 3)); q(6) = atan2(-wrist * R(3, 2), wrist * R(3, 1));
  else
    q(6) = atan2(R(2, 1), R(1, 1));
  end
  q = mod(q + pi, 2 * pi) - pi;
end
