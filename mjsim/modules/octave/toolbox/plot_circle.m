function h = plot_circle(centre, radius, varargin)
% PLOT_CIRCLE  Draws circles: plot_circle(centres, radius, style), a column each.
  hold('on');
  for k = 1:columns(reshape(centre, rows(centre) * (rows(centre) > 1) + numel(centre) * (rows(centre) == 1), []))
    if isvector(centre), c = centre(:); else, c = centre(:, k); end
    p = circle(c(1:2), radius(min(k, numel(radius))));
    h(k) = plot([p(1, :) p(1, 1)], [p(2, :) p(2, 1)], varargin{:});
  end
end
