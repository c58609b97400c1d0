function R = rotx(angle, unit)
% ROTX  The rotation about x, 3 x 3: rotx(angle) or rotx(angle, 'deg').
  if nargin > 1 && strcmp(unit, 'deg'), angle = angle * pi / 180; end
  c = cos(angle); s = sin(angle);
  R = [1 0 0; 0 c -s; 0 s c];
end
