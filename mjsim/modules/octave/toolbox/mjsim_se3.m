function T = mjsim_se3(x, y, z)
% MJSIM_SE3  A pose as SE3 of the later toolbox makes it: SE3(x, y, z), ([x y z]), (R), (T), ().
  if nargin == 0, T = eye(4);
  elseif nargin == 3, T = transl(x, y, z);
  elseif size(x, 1) == 3 && size(x, 2) == 3, T = r2t(x);
  elseif size(x, 1) == 4 && size(x, 2) == 4, T = x;
  elseif nargin == 2, T = rt2tr(x, y);
  else, T = transl(x);
  end
end
