function T = trot2(varargin)
% TROT2  The pose of a rotation in the plane, 3 x 3: trot2(angle) or trot2(angle, 'deg').
  T = rotz(varargin{:})(1:3, 1:3);
end
