function T = trotx(varargin)
% TROTX  The pose of a rotation about x, 4 x 4: trotx(angle) or trotx(angle, 'deg').
  T = eye(4);
  T(1:3, 1:3) = rotx(varargin{:})(1:3, 1:3);
end
