function T = roty(angle, unit)
% ROTY  The rotation about y as the old toolbox has it: a pose, 4 x 4.
  if nargin > 1 && strcmp(unit, 'deg'), angle = angle * pi / 180; end
  c = cos(angle); s = sin(angle);
  T = [c 0 s 0; 0 1 0 0; -s 0 c 0; 0 0 0 1];
end
