function I = mjsim_inertia(v)
% MJSIM_INERTIA  The matrix of [Ixx Iyy Izz Ixy Iyz Ixz], of [Ixx Iyy Izz], or of a matrix.
  if isempty(v)
    I = zeros(3);
  elseif numel(v) == 9
    I = reshape(v, 3, 3);
  elseif numel(v) == 6
    I = [v(1) v(4) v(6); v(4) v(2) v(5); v(6) v(5) v(3)];
  else
    I = diag(v);
  end
end
