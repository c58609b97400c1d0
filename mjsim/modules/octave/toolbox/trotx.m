function T = trotx(varargin)
% TROTX  The pose of a rotation about x, 4 x 4: trotx(angle) or trotx(angle, 'deg').
  T = [rotx(varargin{:}), zeros(3, 1); 0 0 0 1];
end
