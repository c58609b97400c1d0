function showlink(r)
% SHOWLINK  Prints the table of an arm, and its masses and motors.
  if isa(r, 'robot'), display(r); end
  dyn(r);
end
