function disp(r)
% DISP  Prints the table of an arm.
  display(r);
end
