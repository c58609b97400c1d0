function [tau, wrench] = rne(varargin)
% RNE  Torques for a motion, a row for each row of q: rne(r, q, qd, qdd, gravity, fext) or rne(r, [q qd qdd], ...),
%   and the force and moment on the base, in its frame.
%   Viscous friction of a motor is multiplied by the square of its gear ratio, dry friction by the ratio.
  [r, rest] = mjsim_robot(varargin);
  s = mjsim_chain(r);
  n = numel(s.m);
  q = rest{1};
  if size(q, 2) == 3 * n
    [q, qd, qdd] = deal(q(:, 1:n), q(:, n + 1:2 * n), q(:, 2 * n + 1:end));
    rest = rest(2:end);
  else
    [q, qd, qdd] = deal(mjsim_rows(q, n), mjsim_rows(rest{2}, n), mjsim_rows(rest{3}, n));
    rest = rest(4:end);
  end
  gravity = s.gravity; fext = zeros(6, 1);
  if numel(rest) > 0 && ~isempty(rest{1}), gravity = rest{1}; end
  if numel(rest) > 1 && ~isempty(rest{2}), fext = rest{2}; end
  tau = zeros(size(q, 1), n); wrench = zeros(size(q, 1), 6);
  for k = 1:size(q, 1)
    [tau(k, :), ~, wrench(k, :)] = mjsim_rne(s, q(k, :), qd(k, :), qdd(k, :), gravity, fext, 1);
  end
end
