function answer = ishold(varargin)
% ISHOLD  False: whether axes are held is known when they are drawn.
  answer = false;
end
