function v = vex(S)
% VEX  The numbers of a skew-symmetric matrix, 3 x 3 or 2 x 2.
  S = (S - S') / 2;
  if rows(S) == 2, v = S(2, 1); else, v = [S(3, 2); S(1, 3); S(2, 1)]; end
end
