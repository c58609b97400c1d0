function display(r)
% DISPLAY  Prints the table of an arm.
  kinds = {'standard', 'modified'};
  printf('%s: %d axes, %s Denavit-Hartenberg convention\n', r.name, numel(r.links), kinds{any([r.links.mdh]) + 1});
  printf('%12s %12s %12s %12s  sigma\n', 'alpha', 'a', 'theta', 'd');
  for l = r.links
    printf('%12.6g %12.6g %12.6g %12.6g  %d\n', l.alpha, l.a, l.theta, l.d, l.sigma);
  end
end
