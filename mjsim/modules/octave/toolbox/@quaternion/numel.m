function n = numel(q, varargin)
% NUMEL  How many there are; an index or a field gives one object.
  n = 1;
  if nargin == 1, n = size(q.rows, 1); end
end
