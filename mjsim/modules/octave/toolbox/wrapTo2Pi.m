function a = wrapTo2Pi(a)
% WRAPTO2PI  Angles in [0, 2 pi]: positive multiples of 2 pi become 2 pi.
  positive = a > 0;
  a = mod(a, 2 * pi);
  a(a == 0 & positive) = 2 * pi;
end
