function varargout = fplot3(varargin)
% FPLOT3  A curve in space, x(t), y(t) and z(t).
  [f, l, rest] = mjsim_curve(varargin, [0 2*pi]);
  t = linspace(l(1), l(2), 400);
  h = plot3(mjsim_values(f{1}, t), mjsim_values(f{2}, t), mjsim_values(f{3}, t), rest{:});
  if nargout > 0, varargout{1} = h; end
end
