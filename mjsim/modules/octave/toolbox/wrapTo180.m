function a = wrapTo180(a)
% WRAPTO180  Angles in [-180, 180] degrees: 180 stays 180, and -180 stays -180.
  out = abs(a) > 180;
  a(out) = mod(a(out) + 180, 360) - 180 + 360 * (mod(a(out) + 180, 360) == 0 & a(out) > 0);
end
