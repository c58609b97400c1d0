function teach(varargin)
% TEACH  Sliders that move an arm, as drivebot.
  drivebot(varargin{:});
end
