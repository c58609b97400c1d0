function v = VideoWriter(name, varargin)
% VIDEOWRITER  Stands for a film: arms that move are filmed by mjsim itself.
  v = struct('mjsim_film', 1, 'Filename', name, 'FrameRate', 25, 'Quality', 75, 'Duration', 0);
end
