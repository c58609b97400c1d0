function R = rotmat(q, way)
% ROTMAT  Rotations of unit quaternions, 3 x 3 x n: 'point' turns vectors, 'frame' is the transpose.
  rows = q.rows ./ norm(q); R = zeros(3, 3, size(rows, 1));
  for k = 1:size(rows, 1)
    w = rows(k, 1); v = rows(k, 2:4)';
    R(:, :, k) = (w ^ 2 - v' * v) * eye(3) + 2 * (v * v') + 2 * w * skew(v);
  end
  if nargin > 1 && strcmpi(way, 'frame'), R = permute(R, [2 1 3]); end
end
