function varargout = ezplot3(varargin)
% EZPLOT3  As fplot3.
  h = fplot3(varargin{:});
  if nargout > 0, varargout{1} = h; end
end
