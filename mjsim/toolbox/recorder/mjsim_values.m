function y = mjsim_values(f, varargin)
% MJSIM_VALUES  Values of a function, which may return one number for all, a row for each, or take numbers only.
  try
    y = f(varargin{:});
    if isequal(size(y), size(varargin{1})), return, end
  catch
  end
  y = arrayfun(f, varargin{:}, 'UniformOutput', false);
  if all(cellfun(@isscalar, y(:))), y = cell2mat(y); else, y = cell2mat(cellfun(@(a) a(:), y(:)', 'UniformOutput', false))'; end
end
