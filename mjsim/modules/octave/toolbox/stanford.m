% STANFORD  The Stanford arm, as mdl_stanford.
mdl_stanford
