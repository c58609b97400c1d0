function [angles, scale] = mjsim_deg(given)
% MJSIM_DEG  Angles of arguments in radians, one vector or several numbers, and the unit in radians: 1, or a degree.
  words = cellfun(@ischar, given);
  scale = 1;
  for word = given(words)
    if ~any(strcmp(word{1}, {'deg', 'rad', 'zyx', 'xyz', 'yxz', 'arm', 'camera', 'vehicle'}))
      error('''%s'' is not known here; write ''deg'', or an order of roll, pitch and yaw: zyx, xyz or yxz', word{1});
    end
    if strcmp(word{1}, 'zyx')
      warning('zyx is Rz(roll) Ry(pitch) Rx(yaw), as in toolbox 9; for Rz(yaw) Ry(pitch) Rx(roll) write ''vehicle''');
    end
  end
  if any(strcmp(given(words), 'deg')), scale = pi / 180; end
  angles = cellfun(@(a) a(:)', given(~words), 'UniformOutput', false);
  angles = [angles{:}] * scale;
end
