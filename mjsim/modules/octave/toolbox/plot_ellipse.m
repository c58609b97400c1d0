function h = plot_ellipse(E, centre, varargin)
% PLOT_ELLIPSE  Draws x' inv(E) x = 1 about a centre: plot_ellipse(E, centre, style).
  if nargin < 2, centre = [0 0]; end
  t = linspace(0, 2 * pi, 41);
  p = sqrtm(E(1:2, 1:2)) * [cos(t); sin(t)];
  hold('on');
  h = plot(centre(1) + p(1, :), centre(2) + p(2, :), varargin{:});
end
