function R = rpy2r(varargin)
% RPY2R  The rotation of roll, pitch and yaw, as rpy2tr.
  R = t2r(rpy2tr(varargin{:}));
end
