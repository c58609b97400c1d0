function answer = ishandle(value)
% ISHANDLE  Whether a value can be a handle: any number above 0.
  answer = isnumeric(value) & value > 0;
end
