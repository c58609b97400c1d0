function text = mjsim_told(caught, script)
% MJSIM_TOLD  An error as one line, with its place in the script or in a file beside it.
  text = strrep(strtrim(caught.message), "\n", ' ');
  folder = fileparts(script);
  for frame = caught.stack'
    if frame.line > 0 && strncmp(frame.file, folder, numel(folder))
      [unused, name, ending] = fileparts(frame.file);
      text = sprintf('%s (%s%s:%d)', text, name, ending, frame.line);
      return
    end
  end
end
