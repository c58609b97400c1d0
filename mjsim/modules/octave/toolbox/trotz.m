function T = trotz(varargin)
% TROTZ  The pose of a rotation about z, 4 x 4: trotz(angle) or trotz(angle, 'deg').
  T = eye(4);
  T(1:3, 1:3) = rotz(varargin{:})(1:3, 1:3);
end
