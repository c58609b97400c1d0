function r = SerialLink(L, varargin)
% SERIALLINK  An arm of links, or of a matrix with a row [theta d a alpha sigma offset] for each joint.
  if isnumeric(L)
    rows = L;
    clear L
    for k = 1:size(rows, 1)
      L(k) = Link(rows(k, :));
    end
  end
  r = robot(L);
  k = 1;
  while k <= numel(varargin)
    word = varargin{k};
    if ischar(word) && any(strcmp(word, {'modified', 'mod'}))
      r = subsasgn(r, struct('type', '.', 'subs', 'mdh'), 1);
      k = k + 1;
    else
      r = subsasgn(r, struct('type', '.', 'subs', word), varargin{k + 1});
      k = k + 2;
    end
  end
end
