function display(q)
% DISPLAY  Prints quaternions as w < x, y, z >.
  printf('%s =\n', inputname(1)); disp(q);
end
