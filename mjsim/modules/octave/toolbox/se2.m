function T = se2(x, y, angle)
% SE2  The pose of a translation and a rotation in the plane, 3 x 3: se2(x, y, angle), se2([x y angle]).
  if nargin == 1, [x, y, angle] = deal(x(1), x(2), x(3)); elseif nargin == 2, angle = 0; end
  T = transl2(x, y) * trot2(angle);
end
