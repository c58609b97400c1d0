function varargout = fimplicit(varargin)
% FIMPLICIT  The curve f(x, y) = 0.
  [f, l, rest] = mjsim_curve(varargin, [-5 5], 2);
  [x, y] = meshgrid(linspace(l(1), l(2), 200), linspace(l(3), l(4), 200));
  h = contour(x, y, mjsim_values(f{1}, x, y), [0 0], rest{:});
  if nargout > 0, varargout{1} = h; end
end
