function a = wrapToPi(a)
% WRAPTOPI  Angles in [-pi, pi]: pi stays pi, and -pi stays -pi.
  out = abs(a) > pi;
  a(out) = mod(a(out) + pi, 2 * pi) - pi + 2 * pi * (mod(a(out) + pi, 2 * pi) == 0 & a(out) > 0);
end
