function h = mjsim_ellipsoid(r, q, of_force)
% MJSIM_ELLIPSOID  Draws x' inv(J J') x = 1 about the tool, or x' (J J') x = 1.
  J = jacob0(r, q); J = J(1:3, :);
  [V, D] = eig(J * J'); d = sqrt(max(diag(D), 0));
  if of_force, d = 1 ./ max(d, 1e-6); end
  [u, v] = meshgrid(linspace(0, 2 * pi, 30), linspace(0, pi, 15));
  p = V * (d .* [cos(u(:)'); sin(u(:)') ; zeros(1, numel(u))] .* [sin(v(:)'); sin(v(:)'); ones(1, numel(u))] ...
      + d .* [zeros(2, numel(u)); cos(v(:)')]);
  T = fkine(r, q);
  part = @(k) reshape(p(k, :) + T(k, 4), size(u));
  h = mesh(part(1), part(2), part(3));
end
