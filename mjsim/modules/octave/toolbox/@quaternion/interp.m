function p = interp(a, varargin)
% INTERP  interp(a, b, r) from a to b; interp(a, r) from the identity to a, on the shorter way.
  words = cellfun(@ischar, varargin); g = varargin(~words);
  if numel(g) == 1, p = slerp(quaternion(1, 0, 0, 0), a, g{1}); else, p = slerp(a, g{1}, g{2}); end
end
