function R = rotz(angle, unit)
% ROTZ  The rotation about z, 3 x 3: rotz(angle) or rotz(angle, 'deg').
  if nargin > 1 && strcmp(unit, 'deg'), angle = angle * pi / 180; end
  c = cos(angle); s = sin(angle);
  R = [c -s 0; s c 0; 0 0 1];
end
