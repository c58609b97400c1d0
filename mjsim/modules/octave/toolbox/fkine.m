function [T, frames] = fkine(varargin)
% FKINE  Pose of the tool, 4 x 4, or 4 x 4 x k for q with k rows, and those of the links at the last row: fkine(r, q);
%   with 'deg' q in degrees.
  [r, rest] = mjsim_robot(varargin);
  s = mjsim_chain(r);
  q = rest{1};
  n = numel(s.m);
  if any(strcmp('deg', rest)), q = q * pi / 180; end
  if numel(q) == n, q = q(:)'; end
  if size(q, 2) ~= n
    error('q has %d columns; the arm has %d joints', size(q, 2), n);
  end
  T = zeros(4, 4, size(q, 1));
  for k = 1:size(q, 1)
    frames = mjsim_frames(s, q(k, :));
    T(:, :, k) = frames(:, :, s.carrier) * s.tool;
  end
end
