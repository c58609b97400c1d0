function p = mvnpdf(x, mu, sigma)
% MVNPDF  Density of the normal distribution of several variables at each row of x.
  d = columns(x);
  if nargin < 2 || isempty(mu), mu = zeros(1, d); end
  if nargin < 3, sigma = eye(d); end
  L = chol(sigma, 'lower'); e = L \ (x - reshape(mu, [], d))';
  p = exp(-sum(e .^ 2, 1)' / 2) / ((2 * pi) ^ (d / 2) * prod(diag(L)));
end
