function T = trotz(varargin)
% TROTZ  The pose of a rotation about z, 4 x 4: trotz(angle) or trotz(angle, 'deg').
  T = [rotz(varargin{:}), zeros(3, 1); 0 0 0 1];
end
