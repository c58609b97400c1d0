function T = r2t(R)
% R2T  The pose of a rotation.
  T = [R, zeros(3, 1); 0 0 0 1];
end
