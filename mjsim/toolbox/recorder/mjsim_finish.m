function mjsim_finish()
% MJSIM_FINISH  Writes the recorded calls.
  mjsim_record('save', {});
end
