function imwrite(image_, varargin)
% IMWRITE  Writes a picture; one of getframe is drawn by mjsim after the script has ended, into its output folder.
  id = mjsim_frame(image_);
  if id > 0
    mjsim_record('imwrite', [{id}, varargin(cellfun(@ischar, varargin))]);
    return
  end
  before = path();
  rmpath(fileparts(mfilename('fullpath')));
  unwind_protect
    feval('imwrite', image_, varargin{:});
  unwind_protect_cleanup
    path(before);
  end_unwind_protect
end
