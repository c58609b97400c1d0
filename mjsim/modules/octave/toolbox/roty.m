function R = roty(angle, unit)
% ROTY  The rotation about y, 3 x 3: roty(angle) or roty(angle, 'deg').
  if nargin > 1 && strcmp(unit, 'deg'), angle = angle * pi / 180; end
  c = cos(angle); s = sin(angle);
  R = [c 0 s; 0 1 0; -s 0 c];
end
