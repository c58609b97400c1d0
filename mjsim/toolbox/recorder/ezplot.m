function varargout = ezplot(varargin)
% EZPLOT  A curve of a function, y = f(x), of two, x(t) and y(t), or f(x, y) = 0.
  [f, limits, rest] = mjsim_curve(varargin, [-2*pi 2*pi]);
  if numel(f) == 1 && nargin(f{1}) == 2
    h = fimplicit(f{1}, limits);
  else
    t = linspace(limits(1), limits(2), 400);
    data = [{t}, cellfun(@(g) mjsim_values(g, t), f, 'UniformOutput', false)];
    h = plot(data{end - 1:end}, rest{:});
  end
  if nargout > 0, varargout{1} = h; end
end
