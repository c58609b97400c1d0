function p = qinterp(a, varargin)
% QINTERP  interp(a, b, r) from a to b; interp(a, r) from the identity to a, on the shorter way.
  p = interp(a, varargin{:});
end
