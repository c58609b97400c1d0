function L = Prismatic(varargin)
% PRISMATIC  A link that slides: Prismatic('theta', 0, 'a', 0.2, 'alpha', pi/2).
  L = Link(varargin{:});
  L.sigma = 1;
end
