function s = trprint(T, varargin)
% TRPRINT  One line for each pose: position and roll, pitch, yaw in degrees; 'euler', 'radian', 'label', name.
  label = ''; angles = @tr2rpy; name = 'RPY'; scale = 180 / pi; unit_ = 'deg'; k = 1;
  while k <= numel(varargin)
    switch varargin{k}
      case 'euler', angles = @tr2eul; name = 'EUL';
      case 'radian', scale = 1; unit_ = 'rad';
      case 'label', label = [varargin{k + 1} ': ']; k = k + 1;
      case 'fmt', k = k + 1;
    end
    k = k + 1;
  end
  lines_ = '';
  for k = 1:size(T, 3)
    a = angles(T(:, :, k)) * scale;
    lines_ = [lines_ sprintf('%st = (%.3g, %.3g, %.3g), %s = (%.3g, %.3g, %.3g) %s\n', label, T(1:3, 4, k), name, a, unit_)];
  end
  if nargout > 0, s = lines_; else, printf('%s', lines_); end
end
