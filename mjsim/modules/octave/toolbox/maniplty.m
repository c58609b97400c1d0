function m = maniplty(varargin)
% MANIPLTY  Yoshikawa's measure of manipulability at each row of q.
  [r, rest] = mjsim_robot(varargin);
  q = rest{1};
  if isvector(q), q = q(:)'; end
  m = zeros(size(q, 1), 1);
  for k = 1:size(q, 1)
    J = jacob0(r, q(k, :));
    m(k) = sqrt(max(det(J * J'), 0));
  end
end
