function rpy = tr2rpy(T, varargin)
% TR2RPY  Roll, pitch and yaw of a pose, a row for each, as rpy2tr has them; in degrees with 'deg'.
  words = varargin(cellfun(@ischar, varargin));
  sign_ = 1 - 2 * any(ismember({'xyz', 'arm'}, words));
  % In axes z, x, y, the order yxz is zyx.
  turned = any(ismember({'yxz', 'camera'}, words)); back = turned || any(strcmp('vehicle', words));
  rpy = zeros(size(T, 3), 3);
  for k = 1:size(T, 3)
    R = T(1:3, 1:3, k);
    if sign_ < 0, R = R'; end
    if turned, R = R([3 1 2], [3 1 2]); end
    if hypot(R(1, 1), R(2, 1)) < 1e-12
      roll = 0; pitch = atan2(-R(3, 1), R(1, 1)); yaw = atan2(-R(2, 3), R(2, 2));
    else
      roll = atan2(R(2, 1), R(1, 1));
      pitch = atan2(-R(3, 1), cos(roll) * R(1, 1) + sin(roll) * R(2, 1));
      yaw = atan2(sin(roll) * R(1, 3) - cos(roll) * R(2, 3), cos(roll) * R(2, 2) - sin(roll) * R(1, 2));
    end
    rpy(k, :) = [roll pitch yaw];
  end
  [unused, scale] = mjsim_deg(varargin);
  rpy = sign_ * rpy / scale;
  if back, rpy = fliplr(rpy); end
end
