function q = mjsim_rows(q, n)
% MJSIM_ROWS  Values of joints with a row for each posture.
  if numel(q) == n, q = q(:)'; end
end
