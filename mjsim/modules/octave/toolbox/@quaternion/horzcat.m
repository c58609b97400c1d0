function p = horzcat(varargin)
% HORZCAT  As vertcat: quaternions are a column.
  p = vertcat(varargin{:});
end
