function [t, q, qd] = fdyn(varargin)
% FDYN  Motion of an arm under torques: [t, q, qd] = fdyn(r, t0, t1, torque, q0, qd0), torque = f(t, q, qd).
%   The later order has the duration alone, and torque = f(r, t, q, qd); values after qd0 are passed to it.
%   Dry friction holds a joint at rest; the integration stops and goes on where a joint stops or starts.
  [r, rest] = mjsim_robot(varargin);
  c = mjsim_chain(r);
  n = numel(c.m);
  is_later = numel(rest) == 1 || ~isnumeric(rest{2}) || isempty(rest{2});
  if is_later, rest = [{0} rest]; end
  rest = [rest, cell(1, 5 - numel(rest))];
  [start, stop, torque] = rest{1:3}; given = rest(6:end); arm = {};
  x = zeros(2 * n, 1);
  if ~isempty(rest{4}), x(1:n) = rest{4}; end
  if ~isempty(rest{5}), x(n + 1:end) = rest{5}; end
  if is_later && ~isempty(torque) && nargin(torque) == 4 + numel(given), arm = {r}; end
  high = abs(c.G') .* c.Tc(1, :)'; low = abs(c.G') .* c.Tc(2, :)';
  c.Tc(:) = 0;
  dry = high > low;
  SLICES = 10; MAX_TRIES = 30; CLOSE = 1e-7;
  rotors = diag(c.G .^ 2 .* c.Jm);

  function [qdd, f] = motion(time, x)
    % Accelerations, and the friction that keeps joints at rest.
    tau = zeros(1, n);
    if ~isempty(torque), tau = feval(torque, arm{:}, time, x(1:n)', x(n + 1:end)', given{:}); end
    [bias, M] = mjsim_rne(c, x(1:n)', x(n + 1:end)', zeros(1, n), c.gravity, zeros(6, 1), 1);
    M = M + rotors;
    f = (tau(:)' - bias)' - high .* (way > 0) - low .* (way < 0);
    free = way ~= 0 | ~dry;
    qdd = zeros(n, 1);
    qdd(free) = M(free, free) \ f(free);
    f = f - M * qdd;
  end
  function xd = rate(time, x)
    xd = [x(n + 1:end); motion(time, x)];
    xd([dry & way == 0; false(n, 1)]) = 0;
  end
  function v = room(time, x)
    % What is left until joints change: speed in their direction, or friction in reserve.
    [~, need] = motion(time, x);
    v = x(n + 1:end) .* way;
    held = dry & way == 0;
    v(held) = min(high - need, need - low)(held);
    v(~dry) = 1;
  end
  function x = stepped(time, x, h)
    % One step of Runge and Kutta.
    k1 = rate(time, x); k2 = rate(time + h / 2, x + h / 2 * k1); k3 = rate(time + h / 2, x + h / 2 * k2);
    x = x + h / 6 * (k1 + 2 * k2 + 2 * k3 + rate(time + h, x + h * k3));
  end

  way = sign(x(n + 1:end)) .* dry;
  t = start; y = x'; slice = (stop - start) / SLICES; released = [];
  while start < stop - 1e-9 * slice
    % Joints at rest start that friction does not hold, one after the other, since each changes the load of the others.
    at_rest = dry & x(n + 1:end) == 0;
    way(at_rest) = 0;
    for k = 1:n
      left = room(start, x);
      left(~at_rest | way ~= 0) = Inf;
      left(released(way(released) == 0)) = -Inf;
      [least, worst] = min(left);
      if least >= 0, break, end
      [~, need] = motion(start, x);
      way(worst) = sign(2 * need(worst) - high(worst) - low(worst));
    end
    before = room(start, x);
    [times, states] = ode45(@rate, [start, min(start + slice, stop)], x);
    released = [];
    for row = 2:numel(times)
      left = room(times(row), states(row, :)');
      % One that starts may turn within the first step.
      states(row, n + find(left < 0 & before <= 0 & way ~= 0)') = 0;
      over = left < 0 & before > 0;
      if any(over) || any(states(row, n + find(way ~= 0)') == 0), break, end
      before = left;
    end
    times = times(1:row); states = states(1:row, :);
    if any(over)
      % The first change between two rows, by regula falsi.
      from = times(row - 1); h = [0, times(row) - from];
      for k = 1:MAX_TRIES
        share = min(before(over) ./ (before(over) - left(over)));
        middle = h(1) + min(max(share, 0.02), 0.98) * diff(h);
        x = stepped(from, states(row - 1, :)', middle);
        now = room(from + middle, x);
        if any(abs(now(over)) < CLOSE), break, end
        if any(now(over) < 0), h(2) = middle; left = now; else, h(1) = middle; before = now; end
        over = over & left < 0;
      end
      now(~over) = Inf;
      [~, first] = min(abs(now));
      if way(first) == 0, released = first; else, x(n + first) = 0; end
      times(row) = from + middle; states(row, :) = x';
    end
    start = times(end); x = states(end, :)';
    t = [t; times(2:end)]; y = [y; states(2:end, :)];
  end
  q = y(:, 1:n); qd = y(:, n + 1:end);
end
