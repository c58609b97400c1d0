function tau = itorque(varargin)
% ITORQUE  Torques of inertia: itorque(r, q, qdd).
  [r, rest] = mjsim_robot(varargin);
  tau = (inertia(r, rest{1}) * rest{2}(:))';
end
