function mjsim_start(file, folder)
% MJSIM_START  Makes the figure functions record to a file, which is written when Octave ends.
  mjsim_record('open', file);
  atexit('mjsim_finish');
end
