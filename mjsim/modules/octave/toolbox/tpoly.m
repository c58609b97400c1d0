function [s, sd, sdd] = tpoly(s0, s1, t, varargin)
% TPOLY  A quintic from one value to another: [s, sd, sdd] = tpoly(s0, s1, t, sd0, sd1); a number of steps takes 1 each.
  if isscalar(t), t = (0:t - 1)'; end
  [s, sd, sdd] = jtraj(s0, s1, t, varargin{:});
end
