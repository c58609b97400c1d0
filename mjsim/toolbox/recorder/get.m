function v = get(varargin)
% GET  Properties of figures are not kept: positions of a usual window, else nothing.
  v = [];
  if nargin > 1 && ischar(varargin{2}) && any(strcmpi(varargin{2}, {'Position', 'ScreenSize'})), v = [1 1 560 420]; end
end
