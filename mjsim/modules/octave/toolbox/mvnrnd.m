function x = mvnrnd(mu, sigma, n)
% MVNRND  Random rows of the normal distribution of several variables.
  if nargin < 3, n = rows(mu); end
  [V, D] = eig((sigma + sigma') / 2);
  x = mu + randn(n, columns(sigma)) * (V * sqrt(max(D, 0)))';
end
