function T = rotx(angle, unit)
% ROTX  The rotation about x as the old toolbox has it: a pose, 4 x 4.
  if nargin > 1 && strcmp(unit, 'deg'), angle = angle * pi / 180; end
  c = cos(angle); s = sin(angle);
  T = [1 0 0 0; 0 c -s 0; 0 s c 0; 0 0 0 1];
end
