function J = jacob0(varargin)
% JACOB0  The Jacobian of the tool in the frame of the world, 6 x n: jacob0(r, q); with 'trans' or 'rot' three rows of it,
%   with 'rpy' or 'eul' rates of these angles in the last three rows, with 'deg' q in degrees.
  [r, rest] = mjsim_robot(varargin);
  words = lower(rest(cellfun(@ischar, rest))); q = rest{1};
  if any(strcmp('deg', words)), q = q * pi / 180; end
  [J, T] = mjsim_jacobian(mjsim_chain(r), q);
  if any(strcmp('rpy', words)), J(4:6, :) = rpy2jac(tr2rpy(T)) \ J(4:6, :); end
  if any(strcmp('eul', words)), J(4:6, :) = eul2jac(tr2eul(T)) \ J(4:6, :); end
  if any(strcmp('trans', words)), J = J(1:3, :); elseif any(strcmp('rot', words)), J = J(4:6, :); end
end
