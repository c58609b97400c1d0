function R = eul2r(varargin)
% EUL2R  The rotation of Euler's angles, as eul2tr.
  R = t2r(eul2tr(varargin{:}));
end
