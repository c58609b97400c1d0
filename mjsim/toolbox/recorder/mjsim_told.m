function text = mjsim_told(caught, script, recorders)
% MJSIM_TOLD  An error as one line, with its place in the script, its functions, or a file beside it.
  text = strrep(strtrim(caught.message), "\n", ' ');
  folder = fileparts(script);
  own = fullfile(recorders, 'own');
  for frame = caught.stack'
    file = frame.file;
    if strncmp(file, own, numel(own))
      [unused, name] = fileparts(file);
      file = fullfile(folder, [strrep(name, 'mjsim_own_', '') '.m']);
      if ~exist(file, 'file'), file = script; end
    end
    if frame.line > 0 && strncmp(file, folder, numel(folder))
      [unused, name, ending] = fileparts(file);
      text = sprintf('%s (%s%s:%d)', text, name, ending, frame.line);
      return
    end
  end
end
