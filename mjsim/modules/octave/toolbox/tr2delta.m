function d = tr2delta(varargin)
% TR2DELTA  The newer name of tr2diff.
  d = tr2diff(varargin{:});
end
