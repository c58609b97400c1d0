function varargout = ezplot(varargin)
% EZPLOT  As fplot, but from -2 pi to 2 pi.
  [f, limits, rest] = mjsim_curve(varargin, [-2*pi 2*pi]);
  h = fplot(f{:}, limits, rest{:});
  if nargout > 0, varargout{1} = h; end
end
