function [id, current] = mjsim_record(name, given)
% MJSIM_RECORD  Keeps a call of a figure function; mjsim draws them after the script has ended.
  mlock
  persistent calls figure_ file
  if isempty(calls), calls = {}; figure_ = 1; end
  id = numel(calls) + 1;
  if isempty(file) && ~strcmp(name, 'open') && ~isempty(getenv('MJSIM_FIGURES'))
    % In a module: the file is named after the function that mjsim_serve calls.
    frames = dbstack();
    below = find(strcmp({frames.name}, 'mjsim_serve'), 1);
    % Octave itself closes all figures at its end.
    if isempty(below), current = figure_; return, end
    caller = regexprep(frames(max(below - 1, 1)).name, '[^A-Za-z0-9_].*', '');
    folder = strsplit(getenv('MJSIM_FIGURES'), ':'){1};
    file = fullfile(folder, sprintf('%s-%d.mat', caller, getpid()));
    atexit('mjsim_finish');
  end
  switch name
    case 'open'
      file = given;
      return
    case 'save'
      save('-v7', file, 'calls');
      return
    case 'calls'
      id = calls; current = figure_;
      return
    case 'gcf'
      id = figure_;
      return
    case 'figure'
      numbers = cellfun(@(a) isnumeric(a) && isscalar(a), given);
      if any(numbers)
        figure_ = given{find(numbers, 1)};
      elseif ~isempty(calls)
        idle = {'close', 'closereq', 'set', 'waitbar', 'drawnow', 'pause', 'msgbox', 'delete', 'clf', 'figurepalette'};
        shows = ~cellfun(@(c) any(strcmp(char(c{1}.text), idle)), calls);
        figure_ = max([0, cellfun(@(c) c{3}, calls(shows))]) + 1;
      end
      id = figure_;
  end
  if any(strcmp(name, {'plot', 'compass', 'feather', 'scatter', 'line'})) && ~isempty(given) && isnumeric(given{1}) && iscomplex(given{1})
    % One complex array is drawn in its plane.
    if numel(given) == 1 || ischar(given{2})
      given = [{real(given{1}), imag(given{1})}, given(2:end)];
    end
  end
  if any(strcmp(name, {'text', 'legend', 'set', 'xticklabels', 'yticklabels'}))
    % Rows of letters are a text each.
    many = cellfun(@(a) ischar(a) && rows(a) > 1, given);
    given(many) = cellfun(@cellstr, given(many), 'UniformOutput', false);
  end
  handle = id;
  % The handle of axes is no whole number, as numbers of figures and data often are.
  if any(strcmp(name, {'axes', 'gca', 'subplot', 'nexttile', 'newplot'})), handle = id + 2^-13; end
  calls{end + 1} = {mjsim_text(name), cellfun(@plain, given, 'UniformOutput', false), figure_, id};
  id = handle;
  if strncmp(name, 'plot', 4) || strncmp(name, 'semilog', 7) || strcmp(name, 'loglog')
    % One handle for each line: its number in the call is the part of 1.
    id = handle + (0:max(lines_of(given, 2 + strcmp(name, 'plot3')), 1) - 1)' * 2^-20;
  end
end

function count = lines_of(given, dimensions)
% Number of lines that a call draws.
  count = 0; k = 1;
  while k <= numel(given) && ~ischar(given{k})
    last = k;
    while last < numel(given) && last < k + dimensions - 1 && ~ischar(given{last + 1}), last = last + 1; end
    columns_ = cellfun(@(a) prod(size(a)) / max(rows(a) + (rows(a) == 1) * (columns(a) - 1), 1), given(k:last));
    count = count + max([round(columns_) 0]);
    k = last + 1;
    if k <= numel(given) && ischar(given{k}), k = k + 1; end
  end
end

function value = plain(value)
  if ischar(value)
    value = mjsim_text(value);
  elseif isobject(value)
    value = plain(mjsim_plain(value));
  elseif iscell(value)
    value = cellfun(@plain, value, 'UniformOutput', false);
  elseif isstruct(value)
    for k = 1:numel(value)
      for name = fieldnames(value)'
        value(k).(name{1}) = plain(value(k).(name{1}));
      end
    end
  elseif is_function_handle(value)
    value = mjsim_text(func2str(value));
  elseif isnumeric(value) || islogical(value)
    value = double(value);
  end
end

function s = mjsim_text(value)
  if rows(value) > 1, value = strjoin(cellstr(value)', "\n"); end
  s = struct('text', uint8(value));
end
