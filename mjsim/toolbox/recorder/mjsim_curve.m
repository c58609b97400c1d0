function [f, limits, rest] = mjsim_curve(given, limits, dimensions)
% MJSIM_CURVE  Functions among arguments, as handles of arrays, the limits [a b] or [a b c d], and the other arguments.
  if ~isempty(given) && isnumeric(given{1}) && isscalar(given{1}) && isaxes(given{1}), axes(given{1}); given(1) = []; end
  f = {};
  while ~isempty(given) && (is_function_handle(given{1}) || (ischar(given{1}) && isempty(f)))
    f{end + 1} = given{1};
    if ischar(f{end})
      sides = strsplit(f{end}, '=');
      if numel(sides) == 2, f{end} = sprintf('(%s)-(%s)', sides{:}); end
      f{end} = vectorize(inline(f{end}));
      f{end} = str2func(sprintf('@(%s) %s', strjoin(argnames(f{end})', ','), formula(f{end})));
    end
    try
      nargin(f{end});
    catch % of a function that is built in
      builtin_one = f{end};
      f{end} = @(x) builtin_one(x);
    end
    given(1) = [];
  end
  if isempty(f), error('a function is expected, such as @(x) sin(x)'); end
  if ~isempty(given) && isnumeric(given{1})
    if any(numel(given{1}) == [2 4]), limits = given{1}; end
    given(1) = [];
  end
  rest = given;
  if nargin > 2 && dimensions == 2 && numel(limits) == 2, limits = [limits limits]; end
end
