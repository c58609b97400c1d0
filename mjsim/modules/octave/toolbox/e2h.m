function h = e2h(e)
% E2H  Homogeneous coordinates of points, a column each.
  h = [e; ones(1, columns(e))];
end
