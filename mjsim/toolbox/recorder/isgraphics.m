function answer = isgraphics(value, varargin)
% ISGRAPHICS  Whether a value can be a handle: any number above 0.
  answer = ishandle(value);
end
