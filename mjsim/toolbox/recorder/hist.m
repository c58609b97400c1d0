function [count, centre] = hist(y, x, varargin)
% HIST  Counts of values in bins, or their picture: [count, centre] = hist(y, x); x bins, or their centres.
  if nargin < 2, x = 10; end
  if nargout == 0, mjsim_record('hist', {y, x}); return, end
  y = y(:);
  if isscalar(x)
    width = (max(y) - min(y)) / x;
    centre = min(y) + width * ((1:x) - 0.5);
  else
    centre = x(:)';
  end
  bin = 1 + sum(y > [-Inf, (centre(1:end - 1) + centre(2:end)) / 2](2:end), 2);
  count = accumarray(bin, 1, [numel(centre) 1])';
end
