function varargout = ezpolar(varargin)
% EZPOLAR  A curve r(theta).
  [f, l, rest] = mjsim_curve(varargin, [0 2*pi]);
  t = linspace(l(1), l(2), 400);
  h = polar(t, mjsim_values(f{1}, t), rest{:});
  if nargout > 0, varargout{1} = h; end
end
