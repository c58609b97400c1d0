function [s, sd, sdd] = lspb(s0, s1, t, V)
% LSPB  A straight line with parabolic blends: [s, sd, sdd] = lspb(s0, s1, t, V); V is 1.5 times the mean speed unless given.
  if isscalar(t), t = (0:t - 1)'; end
  t = t(:); last = max(t); mean_ = (s1 - s0) / last;
  if nargin < 4, V = 1.5 * mean_; else, V = abs(V) * sign(mean_); end
  if abs(V) < abs(mean_), error('V too small'); end
  if abs(V) > 2 * abs(mean_), error('V too big'); end
  if s0 == s1, s = s0 + 0 * t; sd = 0 * t; sdd = sd; return, end
  blend = last - (s1 - s0) / V; a = V / blend;
  early = min(t, blend); late = max(t - last + blend, 0); even = min(t, last - blend) - early;
  even = max(even, 0);
  s = s0 + a / 2 * early.^2 + V * (even + late) - a / 2 * late.^2;
  sd = a * early - a * late;
  sdd = a * (t <= blend) - a * (t > last - blend);
end
