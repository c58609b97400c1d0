function varargout = pkg(varargin)
% PKG  As Octave's; functions of a package that is loaded come behind those that record figures.
  here = fileparts(mfilename('fullpath')); generated = fileparts(which('plot'));
  rmpath(here);
  unwind_protect
    [varargout{1:nargout}] = feval('pkg', varargin{:});
  unwind_protect_cleanup
    addpath(here);
    if ~isempty(generated), addpath(generated); end
  end_unwind_protect
end
