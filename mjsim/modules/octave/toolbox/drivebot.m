function drivebot(varargin)
% DRIVEBOT  Sliders that move an arm, in the page that --studio opens.
  [r, rest] = mjsim_robot(varargin);
  q = zeros(1, r.n);
  if numel(rest) > 0 && isnumeric(rest{1}), q = rest{1}; end
  mjsim_record('drive', {mjsim_plain(r), double(q)});
end
