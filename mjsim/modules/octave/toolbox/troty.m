function T = troty(varargin)
% TROTY  The pose of a rotation about y, 4 x 4: troty(angle) or troty(angle, 'deg').
  T = [roty(varargin{:}), zeros(3, 1); 0 0 0 1];
end
