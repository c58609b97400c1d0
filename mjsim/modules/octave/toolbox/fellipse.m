function h = fellipse(r, q, varargin)
% FELLIPSE  Draws the ellipsoid of the tool's forces at unit torques of the joints: fellipse(r, q).
  h = mjsim_ellipsoid(r, q, true);
end
