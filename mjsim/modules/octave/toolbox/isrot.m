function answer = isrot(R, varargin)
% ISROT  Whether R is 3 x 3 or 3 x 3 x k.
  answer = isnumeric(R) && ndims(R) <= 3 && rows(R) == 3 && columns(R) == 3;
end
