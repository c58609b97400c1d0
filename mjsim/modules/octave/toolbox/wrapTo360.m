function a = wrapTo360(a)
% WRAPTO360  Angles in [0, 360] degrees: positive multiples of 360 become 360.
  positive = a > 0;
  a = mod(a, 360);
  a(a == 0 & positive) = 360;
end
