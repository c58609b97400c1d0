function plotbot(varargin)
% PLOTBOT  Draws an arm: plotbot(r, q).
  [r, rest] = mjsim_robot(varargin);
  plot(r, rest{:});
end
