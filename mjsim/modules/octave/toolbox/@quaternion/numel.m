function n = numel(q, varargin)
% NUMEL  One object, whatever is asked of it; its count of quaternions is size(double(q), 1).
  n = 1;
end
