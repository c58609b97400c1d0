function h = plot_sphere(centre, radius, varargin)
% PLOT_SPHERE  Draws spheres: plot_sphere(centres, radius, color), a column each; 'alpha', value.
  [w, rest] = mjsim_words(varargin, struct('alpha', 1, 'color', 'b', 'edgecolor', 'none', 'mesh', 'none'));
  if ~isempty(rest), w.color = rest{1}; end
  if isvector(centre), centre = centre(:); end
  [X, Y, Z] = sphere(24); hold('on');
  for k = 1:columns(centre)
    size_ = radius(min(k, numel(radius))); c = centre(:, k);
    h(k) = surf(size_ * X + c(1), size_ * Y + c(2), size_ * Z + c(3), 'FaceColor', w.color, 'EdgeColor', 'none', ...
                'FaceAlpha', w.alpha);
  end
end
