function h = plot_point(p, varargin)
% PLOT_POINT  Draws points, a column each: plot_point(p, style), with 'label', names, or 'sequence'.
  style = {}; names = {}; k = 1;
  while k <= numel(varargin)
    switch varargin{k}
      case {'label', 'printf', 'textcolor', 'textsize'}
        if strcmp(varargin{k}, 'label'), names = varargin{k + 1}; end
        k = k + 1;
      case 'sequence', names = arrayfun(@num2str, 1:columns(p), 'UniformOutput', false);
      case {'bold', 'solid'}
      otherwise, style{end + 1} = varargin{k};
    end
    k = k + 1;
  end
  if isempty(style), style = {'bs'}; end
  hold('on');
  h = plot(p(1, :), p(2, :), style{:});
  if ischar(names), names = {names}; end
  for k = 1:numel(names), text(p(1, k), p(2, k), ['  ' names{k}]); end
end
