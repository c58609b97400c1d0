function limits = mjsim_limits(pane)
% MJSIM_LIMITS  Limits of axes as MATLAB chooses them: those that were set, else round numbers about the data.
  [calls, now] = mjsim_record('calls', {});
  key = ''; keys = struct('x', {{}}, 'made', {{}}, 'handle', {[]});
  names = {}; boxes = {}; fixed = {}; handles = [];
  want = ''; at = NaN;
  if nargin > 0, at = floor(pane); end
  for k = 1:numel(calls)
    [word, given, figure_, id] = calls{k}{:};
    word = char(word.text);
    if any(strcmp(word, {'subplot', 'nexttile', 'axes'}))
      key = sprintf('%g,', figure_, given{cellfun(@isnumeric, given)});
    elseif strcmp(word, 'figure')
      key = sprintf('%g,', figure_);
    end
    if isempty(key), key = sprintf('%g,', figure_); end
    if id == at, want = key; end
    if figure_ ~= now && isnan(at), continue, end
    place = find(strcmp(names, key));
    if isempty(place)
      names{end + 1} = key; boxes{end + 1} = [Inf -Inf Inf -Inf Inf -Inf]; fixed{end + 1} = nan(1, 6);
      place = numel(names);
    end
    if any(strcmp(word, {'clf', 'cla'})), boxes{place} = [Inf -Inf Inf -Inf Inf -Inf]; fixed{place} = nan(1, 6); end
    if ~isempty(given) && isnumeric(given{1}) && isscalar(given{1}) && isaxes(given{1}), given(1) = []; end
    [fixed{place}, boxes{place}] = counted(word, given, fixed{place}, boxes{place});
  end
  if isempty(want), want = key; end
  place = find(strcmp(names, want));
  limits = [0 1 0 1];
  if isempty(place), return, end
  found = boxes{place}; set_ = fixed{place};
  for k = 1:3
    part = 2 * k - 1:2 * k;
    if all(isfinite(found(part))), found(part) = rounded(found(part)); elseif k < 3, found(part) = [0 1]; end
    if all(isfinite(set_(part))), found(part) = set_(part); end
  end
  limits = found(1:4 + 2 * all(isfinite(found(5:6))));
end

function [fixed, box] = counted(word, given, fixed, box)
  part = find(strcmp(word, {'xlim', 'ylim', 'zlim'}));
  if ~isempty(part) && ~isempty(given) && isnumeric(given{1})
    fixed(2 * part - 1:2 * part) = given{1}(1:2);
  elseif strcmp(word, 'axis') && ~isempty(given) && isnumeric(given{1})
    fixed(1:numel(given{1})) = given{1};
  elseif any(strcmp(word, {'plot', 'line', 'scatter', 'stairs', 'stem', 'semilogx', 'semilogy', 'loglog', 'bar', ...
                           'area', 'errorbar', 'fill', 'patch', 'contour', 'contourf', 'pcolor', 'quiver'}))
    box = grown(box, given, 2);
  elseif any(strcmp(word, {'plot3', 'surf', 'mesh', 'scatter3', 'surfc', 'meshc'}))
    box = grown(box, given, 3);
  end
end

function box = grown(box, given, dimensions)
  k = 1;
  while k <= numel(given) && isnumeric(given{k})
    last = k;
    while last < numel(given) && last < k + dimensions - 1 && isnumeric(given{last + 1}), last = last + 1; end
    data = given(k:last);
    if numel(data) == 1 && dimensions == 2
      data = {1:max([rows(data{1}), numel(data{1}) * isvector(data{1})]), data{1}};
    end
    for n = 1:numel(data)
      values = real(double(data{n}(isfinite(data{n}))));
      part = 2 * n - 1:2 * n;
      if ~isempty(values), box(part) = [min([box(part(1)); values(:)]), max([box(part(2)); values(:)])]; end
    end
    k = last + 1;
    if k <= numel(given) && ~isnumeric(given{k}), k = k + 1; end
  end
end

function pair = rounded(pair)
  span = diff(pair);
  if span == 0, pair = pair + [-1 1]; return, end
  % Of the steps with 2 to 10 intervals that which adds least.
  steps = 10 ^ floor(log10(span)) * [2 1 0.5 0.2];
  steps = steps(span ./ steps >= 1.99 & span ./ steps <= 10.01);
  low = floor(pair(1) ./ steps + 1e-9) .* steps; high = ceil(pair(2) ./ steps - 1e-9) .* steps;
  [unused, best] = min(high - low);
  pair = [low(best) high(best)];
end
