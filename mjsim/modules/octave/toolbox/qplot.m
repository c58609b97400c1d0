function h = qplot(t, q)
% QPLOT  Draws joint values over time, or over their rows: qplot(t, q), qplot(q).
  if nargin < 2, q = t; t = (1:rows(q))'; end
  h = plot(t, q);
  grid('on'); xlabel('time'); ylabel('q'); xlim([t(1) t(end)]);
  legend(arrayfun(@(k) sprintf('q%d', k), 1:columns(q), 'UniformOutput', false));
end
