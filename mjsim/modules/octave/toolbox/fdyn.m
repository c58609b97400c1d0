function [t, q, qd] = fdyn(varargin)
% FDYN  Motion of an arm under torques: [t, q, qd] = fdyn(r, t0, t1, torque, q0, qd0), torque = f(t, q, qd).
  [r, rest] = mjsim_robot(varargin);
  n = numel(mjsim_chain(r).m);
  % The later order: the duration, then the torque.
  if numel(rest) == 1 || ~isnumeric(rest{2}) || isempty(rest{2}), rest = [{0} rest]; end
  torque = ''; q0 = zeros(n, 1); qd0 = q0;
  if numel(rest) > 2, torque = rest{3}; end
  if numel(rest) > 3, q0 = rest{4}(:); end
  if numel(rest) > 4, qd0 = rest{5}(:); end
  function xd = rate(time, x)
    tau = zeros(1, n);
    if ~isempty(torque), tau = feval(torque, time, x(1:n)', x(n + 1:end)'); end
    xd = [x(n + 1:end); accel(r, x(1:n), x(n + 1:end), tau)];
  end
  [t, y] = ode45(@rate, [rest{1}, rest{2}], [q0; qd0]);
  q = y(:, 1:n); qd = y(:, n + 1:end);
end
