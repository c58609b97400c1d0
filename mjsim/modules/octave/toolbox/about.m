function about(varargin)
% ABOUT  Prints the class and the size of a variable.
  for k = 1:nargin
    v = varargin{k}; name = inputname(k);
    if ischar(v) && isempty(name), name = v; v = evalin('caller', name); end
    printf('%s [%s] : %s\n', name, class(v), strjoin(arrayfun(@num2str, size(v), 'UniformOutput', false), 'x'));
  end
end
