function L = Revolute(varargin)
% REVOLUTE  A link that turns: Revolute('d', 0.1, 'a', 0.2, 'alpha', pi/2).
  L = Link(varargin{:});
  L.sigma = 0;
end
