function [handles, first, second] = plotyy(x1, y1, x2, y2, varargin)
% PLOTYY  Two plots with a scale on each side.
  yyaxis('left');
  first = plot(x1, y1); handles = gca();
  yyaxis('right');
  second = plot(x2, y2); handles(2) = gca();
end
