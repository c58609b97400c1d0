function J = jacobe(varargin)
% JACOBE  The Jacobian of the tool in its own frame, as jacobn.
  J = jacobn(varargin{:});
end
