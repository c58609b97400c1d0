function T = troty(varargin)
% TROTY  The pose of a rotation about y, 4 x 4: troty(angle) or troty(angle, 'deg').
  T = eye(4);
  T(1:3, 1:3) = roty(varargin{:})(1:3, 1:3);
end
