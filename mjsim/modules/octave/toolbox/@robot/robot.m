function r = robot(L, name, manuf, comment)
% ROBOT  An arm of a cell or an array of links, or of a matrix with a row [alpha A theta D sigma ...] for each joint.
  if nargin > 0 && isa(L, 'robot')
    r = L;
    return
  end
  s = struct('links', [], 'name', 'robot', 'manuf', '', 'comment', '', 'base', eye(4), 'tool', eye(4), ...
             'gravity', [0; 0; 9.81], 'q', [], 'plotopt', {{}}, 'ikineType', '', 'old', true);
  if nargin == 0
    L = {};
  end
  if isnumeric(L)
    rows = L;
    L = cell(1, size(rows, 1));
    for k = 1:numel(L)
      L{k} = link(rows(k, :));
    end
  end
  if isstruct(L)
    L = num2cell(L);
  end
  for k = 1:numel(L)
    s.old = isfield(L{k}, 'A');
    s.links = [s.links, mjsim_link(L{k})];
  end
  if nargin > 1, s.name = name; end
  if nargin > 2, s.manuf = manuf; end
  if nargin > 3, s.comment = comment; end
  r = class(s, 'robot');
end
