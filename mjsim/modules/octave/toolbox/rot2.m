function R = rot2(varargin)
% ROT2  The rotation in the plane, 2 x 2: rot2(angle) or rot2(angle, 'deg').
  R = rotz(varargin{:})(1:2, 1:2);
end
