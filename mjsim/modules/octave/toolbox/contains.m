function answer = contains(text, pattern, varargin)
% CONTAINS  Whether texts contain a pattern, or one of several; with 'IgnoreCase', true in any case.
  if ischar(text), text = {text}; one = true; else, one = false; end
  if ischar(pattern), pattern = {pattern}; end
  if numel(varargin) > 1 && varargin{2}, text = lower(text); pattern = lower(pattern); end
  answer = false(size(text));
  for k = 1:numel(text), answer(k) = any(cellfun(@(p) ~isempty(strfind(text{k}, p)), pattern)); end
  if one, answer = answer(1); end
end
