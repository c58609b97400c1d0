function p = mjsim_product(a, b)
% MJSIM_PRODUCT  Products of quaternions [w x y z], by rows; one row serves all of the other.
  w = a(:, 1); u = a(:, 2:4); s = b(:, 1); v = b(:, 2:4); n = max(size(a, 1), size(b, 1));
  turned = cross(repmat(u, n / size(a, 1), 1), repmat(v, n / size(b, 1), 1), 2);
  p = [w .* s - sum(u .* v, 2), w .* v + s .* u + turned];
end
