function varargout = plot3d(varargin)
% PLOT3D  As plot: arms are drawn as lines.
  [varargout{1:nargout}] = plot(varargin{:});
end
