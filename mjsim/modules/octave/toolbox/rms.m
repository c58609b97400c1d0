function y = rms(x, varargin)
% RMS  Root of the mean of squares of each column, or along a dimension.
  y = sqrt(mean(abs(x) .^ 2, varargin{:}));
end
