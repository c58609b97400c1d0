function writeVideo(v, frames)
% WRITEVIDEO  Adds frames to a film.
  if isnumeric(frames), frames = struct('cdata', {frames}); end
  ids = arrayfun(@(f) mjsim_frame(f.cdata), frames(:)');
  if any(ids == 0), error('writeVideo takes frames of getframe only'); end
  mjsim_record('writeVideo', {v.Filename, v.FrameRate, ids});
end
