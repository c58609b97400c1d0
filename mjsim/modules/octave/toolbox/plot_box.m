function h = plot_box(varargin)
% PLOT_BOX  Draws a rectangle: plot_box(x1, y1, x2, y2, style), plot_box([x1 x2; y1 y2], style), or 'centre', 'size'.
  if ischar(varargin{1})
    c = varargin{2}; s = varargin{4} .* [1 1]; b = [c(:) - s(:) / 2, c(:) + s(:) / 2]; rest = varargin(5:end);
  elseif isscalar(varargin{1})
    b = [varargin{1} varargin{3}; varargin{2} varargin{4}]; rest = varargin(5:end);
  else
    b = varargin{1}; rest = varargin(2:end);
  end
  hold('on');
  h = plot(b(1, [1 2 2 1 1]), b(2, [1 1 2 2 1]), rest{:});
end
