function dyn(what)
% DYN  Prints masses, inertias, motors and friction of the links of an arm, or of a link: dyn(r).
  if isa(what, 'robot')
    links = what.links; name = what.name;
  else
    links = what; name = 'link';
  end
  for k = 1:numel(links)
    l = mjsim_link(links(k)); I = l.I;
    printf('%s %d\n', name, k);
    printf('  m    %12.6g\n  r    %12.6g %12.6g %12.6g\n', l.m, l.r);
    printf('  I    %12.6g %12.6g %12.6g\n       %12.6g %12.6g %12.6g\n       %12.6g %12.6g %12.6g\n', I');
    printf('  Jm   %12.6g\n  B    %12.6g\n  Tc   %12.6g %12.6g\n  G    %12.6g\n', l.Jm, l.B, l.Tc, l.G);
  end
end
