function p = circle(centre, radius, varargin)
% CIRCLE  Points of a circle, a column each: circle(centre, radius).
  t = linspace(0, 2 * pi, 51)(1:50);
  p = centre(1:2)(:) + radius * [cos(t); sin(t)];
  if numel(centre) > 2, p(3, :) = centre(3); end
end
