function answer = isvec(v, n)
% ISVEC  Whether v is a vector of n numbers, 3 unless given.
  if nargin < 2, n = 3; end
  answer = isnumeric(v) && isvector(v) && numel(v) == n;
end
