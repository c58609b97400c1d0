function [n, edges] = histcounts(x, edges)
% HISTCOUNTS  Numbers of values between edges, or in a number of bins of one width.
  if nargin < 2, edges = max(ceil(sqrt(numel(x))), 1); end
  if isscalar(edges), edges = linspace(min(x(:)), max(x(:)), edges + 1); end
  n = histc(x(:)', edges);
  n(end - 1) = n(end - 1) + n(end); n(end) = [];
end
