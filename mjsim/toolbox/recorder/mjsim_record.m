function id = mjsim_record(name, given)
% MJSIM_RECORD  Keeps a call of a figure function; mjsim draws them after the script has ended.
  mlock
  persistent calls figure_ file
  if isempty(calls), calls = {}; figure_ = 1; end
  id = numel(calls) + 1;
  switch name
    case 'open'
      file = given;
      return
    case 'save'
      save('-v7', file, 'calls');
      return
    case 'gcf'
      id = figure_;
      return
    case 'figure'
      numbers = cellfun(@(a) isnumeric(a) && isscalar(a), given);
      if any(numbers)
        figure_ = given{find(numbers, 1)};
      elseif ~isempty(calls)
        figure_ = max(cellfun(@(c) c{3}, calls)) + 1;
      end
      id = figure_;
  end
  calls{end + 1} = {mjsim_text(name), cellfun(@plain, given, 'UniformOutput', false), figure_, id};
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
