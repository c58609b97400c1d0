function L = mjsim_old(l)
% MJSIM_OLD  A link with the names of the old toolbox.
  L = link([l.alpha l.a l.theta l.d l.sigma]);
  for name = {'offset', 'mdh', 'm', 'r', 'I', 'Jm', 'G', 'B', 'Tc', 'qlim'}
    L.(name{1}) = l.(name{1});
  end
end
