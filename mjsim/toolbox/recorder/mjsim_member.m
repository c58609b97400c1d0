function v = mjsim_member(x, name, varargin)
% MJSIM_MEMBER  A method of a link, which is a struct: its pose at a joint's value, or whether it turns.
  if strcmp(name, '()') && isstruct(x) && isfield(x, 'mdh') && isnumeric(varargin{1})
    r = robot({x});
    v = r.A(1, varargin{1});
  elseif strcmp(name, '()')
    v = x(varargin{:});
  elseif ~(isstruct(x) && isfield(x, 'sigma') && isfield(x, 'mdh')) || isfield(x, name)
    v = x.(name);
    if nargin > 2, v = v(varargin{:}); end
  elseif strcmp(name, 'RP')
    v = 'RP'(1 + (x.sigma ~= 0));
  elseif strcmp(name, 'A')
    r = robot({x});
    v = r.A(1, varargin{1});
  else
    v = strcmp(name, 'isrevolute') == (x.sigma == 0);
  end
end
