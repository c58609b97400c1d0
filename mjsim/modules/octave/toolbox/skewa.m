function S = skewa(s)
% SKEWA  4 x 4 matrix of a twist of 6 numbers, 3 x 3 of one of 3.
  n = numel(s) / 2 * (numel(s) == 6) + 2 * (numel(s) == 3);
  S = [skew(s(n + 1:end)) reshape(s(1:n), n, 1); zeros(1, n + 1)];
end
