function answer = ishomog(T, varargin)
% ISHOMOG  Whether T is a pose, 4 x 4 or 4 x 4 x k.
  answer = isnumeric(T) && ndims(T) <= 3 && rows(T) == 4 && columns(T) == 4;
end
