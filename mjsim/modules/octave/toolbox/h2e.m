function e = h2e(h)
% H2E  Points of homogeneous coordinates, a column each.
  e = h(1:end - 1, :) ./ h(end, :);
end
