function J = jacob0(varargin)
% JACOB0  The Jacobian of the tool in the frame of the world, 6 x n: jacob0(r, q).
  [r, rest] = mjsim_robot(varargin);
  J = mjsim_jacobian(mjsim_chain(r), rest{1});
end
