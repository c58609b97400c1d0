function T = trexp(S, theta)
% TREXP  Pose or rotation of a skew matrix, a twist of 6 numbers or a vector of 3: trexp(S, theta).
  if isvector(S) && numel(S) == 6, S = skewa(S); elseif isvector(S), S = skew(S); end
  if nargin < 2, theta = 1; end
  T = expm(S * theta);
end
