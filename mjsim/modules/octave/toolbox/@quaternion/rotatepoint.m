function p = rotatepoint(q, p)
% ROTATEPOINT  Points turned, rows of 3.
  p = p * rotmat(q, 'point')';
end
