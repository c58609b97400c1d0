function answer = ishghandle(value, varargin)
% ISHGHANDLE  Whether a value can be a handle: any number above 0.
  answer = ishandle(value);
end
