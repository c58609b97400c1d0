function p = vertcat(varargin)
% VERTCAT  Quaternions in one column.
  parts = cellfun(@(q) q.rows, varargin, 'UniformOutput', false);
  p = quaternion(vertcat(parts{:}));
end
