function answer = isaxes(value, varargin)
% ISAXES  Whether a value can be a handle: any number above 0.
  answer = ishandle(value);
end
