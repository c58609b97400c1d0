function handles = findobj(varargin)
% FINDOBJ  Nothing: what is drawn has no list.
  handles = [];
end
