function m = maniplty(varargin)
% MANIPLTY  Yoshikawa's measure of manipulability at each row of q, or with 'asada' Asada's, the ratio of the least and
%   the largest inertia of the tool; of translations with 'T' ('trans'), of rotations with 'R' ('rot').
  [r, rest] = mjsim_robot(varargin);
  words = lower(rest(cellfun(@ischar, rest))); q = mjsim_rows(rest{1}, r.n); part = 1:6;
  if any(ismember({'t', 'trans'}, words)), part = 1:3; elseif any(ismember({'r', 'rot'}, words)), part = 4:6; end
  m = zeros(size(q, 1), 1);
  for k = 1:size(q, 1)
    J = jacob0(r, q(k, :));
    if any(strcmp('asada', words))
      Ji = pinv(J); felt = Ji' * inertia(r, q(k, :)) * Ji; e = eig(felt(part, part));
      m(k) = min(real(e)) / max(real(e));
    else
      m(k) = sqrt(max(det(J(part, :) * J(part, :)'), 0));
    end
  end
end
