function v = get(h, name, varargin)
% GET  Properties that a script has set or drawn, limits and data, or what a usual window has; else nothing.
  v = [];
  if nargin < 2 || ~ischar(name) || isempty(h), return, end
  switch lower(name)
    case {'position', 'outerposition', 'screensize', 'innerposition'}, v = [1 1 560 420];
    case 'xlim', v = xlim(h);
    case 'ylim', v = ylim(h);
    case 'zlim', v = zlim(h);
    case {'currentaxes', 'parent'}, v = gca();
    case 'number', v = h;
    case {'xlabel', 'ylabel', 'zlabel', 'title'}, v = mjsim_record('label_of', {h(1), lower(name)});
    case 'type'
      v = 'line';
      if isaxes(h), v = 'axes'; end
    otherwise
      v = kept(h(1), lower(name));
      if isempty(v), v = usual(lower(name)); end
  end
end

function v = usual(name)
  v = [];
  switch name
    case {'colororder', 'defaultaxescolororder'}
      v = [0 0.447 0.741; 0.85 0.325 0.098; 0.929 0.694 0.125; 0.494 0.184 0.556; 0.466 0.674 0.188; ...
           0.301 0.745 0.933; 0.635 0.078 0.184];
    case 'linewidth', v = 0.5;
    case 'markersize', v = 6;
    case 'fontsize', v = 10;
    case 'color', v = [0 0.447 0.741];
    case 'linestyle', v = '-';
    case 'marker', v = 'none';
    case 'units', v = 'pixels';
    case {'visible', 'box'}, v = 'on';
    case 'nextplot', v = 'replace';
      if ishold(), v = 'add'; end
    case {'xscale', 'yscale', 'zscale'}, v = 'linear';
    case {'xtick', 'ytick', 'ztick'}
      v = linspace(feval([name(1) 'lim'])(1), feval([name(1) 'lim'])(2), 6);
    case 'view', v = [-37.5 30];
  end
end

function v = kept(h, name)
% What was set last or given when it was drawn, else the data that were drawn.
  calls = mjsim_record('calls', {}); v = [];
  coordinate = find(strcmp(name, {'xdata', 'ydata', 'zdata'}));
  for k = 1:numel(calls)
    [word, given, figure_, id] = calls{k}{:};
    if strcmp(char(word.text), 'set') && numel(given) > 2 && isnumeric(given{1}) && any(abs(given{1}(:) - h) < 2^-24)
      for n = 2:2:numel(given) - 1
        if isstruct(given{n}) && strcmpi(char(given{n}.text), name), v = given{n + 1}; end
      end
    elseif id == floor(h) && ~isempty(coordinate)
      data = given(cumsum(~cellfun(@isnumeric, given)) == 0);
      if coordinate == 2 && numel(data) == 1, coordinate_ = 1; else, coordinate_ = coordinate; end
      if coordinate_ <= numel(data), v = data{coordinate_}; end
      line_ = round((mod(h, 1)) * 2^20) + 1;
      if ~isempty(v) && ~isvector(v), v = v(:, min(line_, columns(v)))'; end
      if isvector(v), v = v(:)'; end
    elseif id == floor(h)
      for n = 1:numel(given) - 1
        if isstruct(given{n}) && isfield(given{n}, 'text') && strcmpi(char(given{n}.text), name), v = given{n + 1}; end
      end
    end
  end
  if isstruct(v) && isfield(v, 'text'), v = char(v.text); end
end
