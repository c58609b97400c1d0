function M = cinertia(varargin)
% CINERTIA  The mass matrix in the coordinates of the tool: cinertia(r, q).
  [r, rest] = mjsim_robot(varargin);
  J = inv(jacob0(r, rest{1}));
  M = J' * inertia(r, rest{1}) * J;
end
