function T = rotz(angle, unit)
% ROTZ  The rotation about z as the old toolbox has it: a pose, 4 x 4.
  if nargin > 1 && strcmp(unit, 'deg'), angle = angle * pi / 180; end
  c = cos(angle); s = sin(angle);
  T = [c -s 0 0; s c 0 0; 0 0 1 0; 0 0 0 1];
end
