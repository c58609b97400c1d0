function q = quaternion(varargin)
% QUATERNION  q = quaternion(w, x, y, z), ([w x y z]), (R or T), (angle, axis) or (axis, angle), (e, 'euler', 'ZYX', 'frame'),
%   (R, 'rotmat', 'point'), (v, 'rotvec'). A row for each; q.R, q.T, q.s, q.v, inv, norm, unit, *, /, interp, slerp.
  a = varargin; words = lower(a(cellfun(@ischar, a))); a = a(~cellfun(@ischar, a)); way = 1;
  if isempty(a), a = {[1 0 0 0]}; end
  if any(strcmp(words, 'frame')), way = -1; end
  if isobject(a{1}), rows = a{1}.rows;
  elseif numel(a) == 4, rows = [a{1}(:), a{2}(:), a{3}(:), a{4}(:)];
  elseif numel(a) == 2 && numel(a{1}) + numel(a{2}) == 4
    if numel(a{1}) == 3, a = a([2 1]); end
    rows = [cos(a{1} / 2), sin(a{1} / 2) * a{2}(:)' / norm(a{2})];
  elseif any(strcmp(words, 'rotvec')) || any(strcmp(words, 'rotvecd'))
    v = a{1}; if any(strcmp(words, 'rotvecd')), v = v * pi / 180; end
    angles = sqrt(sum(v .^ 2, 2)); rows = [cos(angles / 2), sin(angles / 2) .* v ./ max(angles, realmin)];
  elseif any(strcmp(words, 'euler')) || any(strcmp(words, 'eulerd'))
    order = words(cellfun(@(w) numel(w) == 3 && all(ismember(w, 'xyz')), words)); turns = eye(3);
    if isempty(order) || way > 0, error('quaternion of Euler angles: give an order as ''ZYX'' and ''frame'''); end
    e = a{1}; if any(strcmp(words, 'eulerd')), e = e * pi / 180; end
    rows = repmat([1 0 0 0], size(e, 1), 1);
    for k = 1:3
      rows = mjsim_product(rows, [cos(e(:, k) / 2), sin(e(:, k) / 2) .* repmat(turns('xyz' == order{1}(k), :), size(e, 1), 1)]);
    end
  elseif size(a{1}, 1) > 2 && (size(a{1}, 2) == 3 || (size(a{1}, 1) == 4 && isequal(a{1}(4, 1:3), [0 0 0])))
    rows = zeros(size(a{1}, 3), 4);
    for k = 1:size(rows, 1), rows(k, :) = of_rotation(a{1}(1:3, 1:3, k)); end
    rows(:, 2:4) *= way;
  elseif size(a{1}, 2) == 4, rows = a{1};
  elseif numel(a{1}) == 4, rows = a{1}(:)';
  elseif numel(a{1}) == 3, rows = [0, a{1}(:)'];
  elseif numel(a{1}) == 1, rows = [a{1} 0 0 0];
  else, error('quaternion takes w, x, y, z; a rotation; or an angle and an axis');
  end
  q = class(struct('rows', rows), 'quaternion');
end
function row = of_rotation(R)
% The column of the largest element of 4 q q' is the most exact one.
  s = trace(R); d = diag(R)'; w = [R(3, 2) - R(2, 3), R(1, 3) - R(3, 1), R(2, 1) - R(1, 2)];
  M = [1 + s, w; w', R + R' + diag(1 - s * [1 1 1])];
  [~, k] = max(diag(M));
  row = M(k, :) / norm(M(k, :)) * sign(sign(M(k, 1)) + 0.5);
end
