function T = rpy2tr(varargin)
% RPY2TR  The pose of roll, pitch and yaw: Rz(roll) Ry(pitch) Rx(yaw), as the old toolbox has them ('zyx' in toolbox 9);
%   'xyz' or 'arm': Rx(yaw) Ry(pitch) Rz(roll); 'yxz' or 'camera': Ry(yaw) Rx(pitch) Rz(roll); 'vehicle': Rz(yaw) Ry Rx.
  a = mjsim_deg(varargin); words = varargin(cellfun(@ischar, varargin));
  if any(ismember({'xyz', 'arm'}, words))
    T = trotx(a(3)) * troty(a(2)) * trotz(a(1));
  elseif any(ismember({'yxz', 'camera'}, words))
    T = troty(a(3)) * trotx(a(2)) * trotz(a(1));
  elseif any(strcmp('vehicle', words))
    T = trotz(a(3)) * troty(a(2)) * trotx(a(1));
  else
    T = trotz(a(1)) * troty(a(2)) * trotx(a(3));
  end
end
