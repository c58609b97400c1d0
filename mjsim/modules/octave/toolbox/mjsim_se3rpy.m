function T = mjsim_se3rpy(varargin)
% MJSIM_SE3RPY  A pose of roll, pitch and yaw as SE3.rpy of the later toolbox has them: about x, y and z, yaw first.
  given = varargin(cellfun(@isnumeric, varargin)); words = varargin(cellfun(@ischar, varargin));
  if numel(given) == 3, given = {[given{:}]}; end
  T = rpy2tr(fliplr(given{1}), words{:});
end
