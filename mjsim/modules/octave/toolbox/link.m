function L = link(varargin)
% LINK  A link of an arm in the order of the old toolbox: link([alpha A theta D sigma offset], convention).
%   A row of 20 numbers also has mass, centre (3), inertia (6), Jm, G, B and Tc (2).
  row = [];
  if nargin > 0 && isnumeric(varargin{1})
    row = varargin{1}(:)';
  end
  L = struct('alpha', 0, 'A', 0, 'theta', 0, 'D', 0, 'sigma', 0, 'mdh', 0, 'offset', 0, 'm', 0, 'r', [0 0 0], ...
             'I', zeros(3), 'Jm', 0, 'G', 1, 'B', 0, 'Tc', [0 0], 'qlim', []);
  names = {'alpha', 'A', 'theta', 'D', 'sigma'};
  for k = 1:min(numel(row), 5)
    L.(names{k}) = row(k);
  end
  if numel(row) == 6
    L.offset = row(6);
  end
  if numel(row) >= 20
    L.m = row(6); L.r = row(7:9); L.I = row(10:15); L.Jm = row(16); L.G = row(17); L.B = row(18); L.Tc = row(19:20);
  end
  if nargin > 1 && ischar(varargin{2})
    L.mdh = any(strcmpi(varargin{2}, {'modified', 'mod'}));
  end
end
