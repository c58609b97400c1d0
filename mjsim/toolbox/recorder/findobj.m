function handles = findobj(varargin)
% FINDOBJ  Lines, axes or texts of the current figure: findobj(gcf, 'Type', 'line'); nothing for other conditions.
  words = lower(varargin(cellfun(@ischar, varargin))); handles = zeros(0, 1);
  at = find(strcmp(words, 'type'), 1);
  if isempty(at) || numel(words) ~= at + 1, return, end
  makers = struct('line', {{'plot', 'plot3', 'line', 'semilogx', 'semilogy', 'loglog', 'stairs', 'stem'}}, ...
                  'axes', {{'subplot', 'axes', 'nexttile', 'gca'}}, 'text', {{'text'}}, 'patch', {{'fill', 'patch'}}, ...
                  'surface', {{'surf', 'mesh'}});
  if ~isfield(makers, words{at + 1}), return, end
  calls = mjsim_record('calls', {}); now = gcf();
  for k = 1:numel(calls)
    [word, given, figure_, id] = calls{k}{:};
    % This part of 1 names all that a call drew.
    if figure_ == now && any(strcmp(char(word.text), makers.(words{at + 1}))), handles(end + 1, 1) = id + 2^-12; end
  end
  if strcmp(words{at + 1}, 'axes'), handles = handles - 2^-13; end
end
