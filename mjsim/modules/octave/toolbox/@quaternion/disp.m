function disp(q)
% DISP  Prints quaternions as w < x, y, z >.
  printf('%.5g < %.5g, %.5g, %.5g >\n', q.rows');
end
