function d = tr2diff(T1, T2)
% TR2DIFF  The small motion between two poses, or of one pose, 6 x 1.
  if nargin == 1, T2 = T1; T1 = eye(4); end
  R = T2(1:3, 1:3) * T1(1:3, 1:3)' - eye(3);
  d = [T2(1:3, 4) - T1(1:3, 4); [R(3, 2) - R(2, 3); R(1, 3) - R(3, 1); R(2, 1) - R(1, 2)] / 2];
end
