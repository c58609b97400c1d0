function [q, err, flag, info] = ikunc(r, T, varargin)
% IKUNC  Joint values that bring the tool to a pose, without limits: ikunc(r, T, q0).
  [q, err] = ikine(r, T, varargin{:});
  flag = err < 1e-9; info = '';
end
