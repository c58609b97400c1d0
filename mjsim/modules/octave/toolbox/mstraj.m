function [q, t] = mstraj(via, qdmax, tsegment, q0, dt, tacc, varargin)
% MSTRAJ  A path along straight lines with parabolic blends: [q, t] = mstraj(via, qdmax, tsegment, q0, dt, tacc).
%   qdmax: largest speed of each axis; or tsegment: duration of each line. Blends of duration tacc pass beside the points.
  if isempty(q0), q0 = via(1, :); via = via(2:end, :); end
  points = [q0(:)'; via]; steps = diff(points);
  if isempty(tsegment)
    lasts = max(abs(steps) ./ (qdmax(:)' .* ones(1, columns(points))), [], 2);
  else
    lasts = tsegment(:);
  end
  lasts = max(ceil(lasts / dt - 1e-9), 1) * dt;
  knots = tacc / 2 + [0; cumsum(lasts)];
  t = (0:dt:knots(end) + tacc / 2 + dt / 1e6)';
  if tacc == 0
    q = interp1(knots, points, min(max(t, knots(1)), knots(end)));
    return
  end
  % The mean of the straight lines over a window of tacc has parabolic blends.
  knots = [-tacc; knots; knots(end) + 2 * tacc]; points = points([1 1:end end], :);
  area = [zeros(1, columns(points)); cumsum(diff(knots) .* (points(1:end - 1, :) + points(2:end, :)) / 2)];
  q = (total(t + tacc / 2, knots, points, area) - total(t - tacc / 2, knots, points, area)) / tacc;
end

function a = total(t, knots, points, area)
  k = max(sum(t >= knots', 2), 1); k = min(k, numel(knots) - 1);
  h = t - knots(k);
  slope = (points(k + 1, :) - points(k, :)) ./ (knots(k + 1) - knots(k));
  a = area(k, :) + h .* points(k, :) + h.^2 / 2 .* slope;
end
