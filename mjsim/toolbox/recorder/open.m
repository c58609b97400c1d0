function open(what)
% OPEN  Nothing for a film; else names what is not opened.
  if ~isstruct(what), error('open(''%s'') needs a window', what); end
end
