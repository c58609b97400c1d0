function h = vellipse(r, q, varargin)
% VELLIPSE  Draws the ellipsoid of the tool's velocities at unit rates of the joints: vellipse(r, q).
  h = mjsim_ellipsoid(r, q, false);
end
