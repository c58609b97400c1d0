function answer = isaxes(value, varargin)
% ISAXES  Whether a value is a handle of axes, which are no whole numbers.
  answer = isnumeric(value) & value > 0;
  answer(answer) = abs(mod(value(answer), 1) - 2^-13) < 2^-24;
end
