function p = rotateframe(q, p)
% ROTATEFRAME  Points in the turned frame, rows of 3.
  p = p * rotmat(q, 'point');
end
