function varargout = ezmeshc(varargin)
% EZMESHC  The function f(x, y) over a grid, drawn by mesh.
  [f, l, rest] = mjsim_curve(varargin, [-5 5], 2);
  [x, y] = meshgrid(linspace(l(1), l(2), 60), linspace(l(3), l(4), 60));
  h = mesh(x, y, mjsim_values(f{1}, x, y), rest{:});
  if nargout > 0, varargout{1} = h; end
end
