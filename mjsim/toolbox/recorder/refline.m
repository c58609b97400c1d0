function h = refline(slope, offset)
% REFLINE  A straight line across the axes.
  if nargin == 1, [slope, offset] = deal(slope(1), slope(2)); end
  x = xlim(gca());
  h = line(x, slope * x + offset, 'Color', 'k');
end
