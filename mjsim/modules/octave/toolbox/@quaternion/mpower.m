function p = mpower(q, n)
% MPOWER  Power of a unit quaternion: its angle times n.
  p = slerp(quaternion(1, 0, 0, 0), q, n, 'long');
end
