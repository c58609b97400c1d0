function handles = findall(varargin)
% FINDALL  As findobj.
  handles = findobj(varargin{:});
end
