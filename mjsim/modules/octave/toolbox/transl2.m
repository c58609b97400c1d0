function T = transl2(x, y)
% TRANSL2  The pose of a translation in the plane, or the translation of a pose: transl2(x, y), transl2([x y]), transl2(T).
  if nargin == 2, x = [x y]; end
  if numel(x) == 9, T = x(1:2, 3); else, T = [1 0 x(1); 0 1 x(2); 0 0 1]; end
end
