function plot(q, varargin)
% PLOT  Draws the turned frame of the first, as trplot.
  trplot(rotmat(q, 'point')(:, :, 1), varargin{:});
end
