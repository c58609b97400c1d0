function L = Link(varargin)
% LINK  A link of an arm: Link([theta d a alpha sigma offset], convention) or Link('d', 0.1, 'a', 0.2, ...).
  L = struct('theta', 0, 'd', 0, 'a', 0, 'alpha', 0, 'sigma', 0, 'offset', 0, 'mdh', 0, 'flip', 0, 'm', 0, ...
             'r', [0 0 0], 'I', zeros(3), 'Jm', 0, 'G', 1, 'B', 0, 'Tc', [0 0], 'qlim', []);
  k = 1;
  if nargin > 0 && isnumeric(varargin{1})
    row = varargin{1}(:)';
    names = {'theta', 'd', 'a', 'alpha', 'sigma', 'offset'};
    for n = 1:min(numel(row), 6)
      L.(names{n}) = row(n);
    end
    k = 2;
  end
  while k <= nargin
    word = varargin{k};
    switch lower(word)
      case {'standard', 'revolute'}
      case {'modified', 'mod'}
        L.mdh = 1;
      case 'prismatic'
        L.sigma = 1;
      otherwise
        if ~isfield(L, word) || k == nargin
          error('Link has no parameter ''%s''', word);
        end
        L.(word) = varargin{k + 1};
        if strcmp(word, 'theta')
          L.sigma = 1;
        end
        k = k + 1;
    end
    k = k + 1;
  end
end
