function v = VideoWriter(name, varargin)
% VIDEOWRITER  A film of the frames that writeVideo gets, which mjsim writes after the script has ended.
  v = struct('mjsim_film', 1, 'Filename', name, 'FrameRate', 30, 'Quality', 75, 'Duration', 0);
end
