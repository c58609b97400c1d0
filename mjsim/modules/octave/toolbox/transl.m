function [T, y, z] = transl(x, y, z)
% TRANSL  The pose of a translation, or the translation of poses: transl(x, y, z), transl([x y z]), transl(T).
  if nargin == 3
    T = eye(4); T(1:3, 4) = [x; y; z];
  elseif size(x, 1) == 4 && size(x, 2) == 4
    T = reshape(x(1:3, 4, :), 3, [])';
    if size(T, 1) == 1, T = T'; end
    if nargout == 3, [T, y, z] = deal(T(1), T(2), T(3)); end
  elseif numel(x) == 3
    T = eye(4); T(1:3, 4) = x(:);
  else
    T = repmat(eye(4), [1 1 size(x, 1)]);
    T(1:3, 4, :) = reshape(x', 3, 1, []);
  end
end
