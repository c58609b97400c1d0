% Rotations and paths in the words of later editions of the toolbox.
angles = [0.3 -0.7 1.9];
R = rpy2r(angles);  E = eul2r(angles);
T = angvec2tr(1.2, [1 2 -2]);
[angle, axis] = tr2angvec(T);
[half, about] = tr2angvec(angvec2r(pi, [0 3 4]));
w = [0.1 -0.2 0.3];  S = skew(w);  v = vex(S);
d = tr2delta(delta2tr([1e-3 2e-3 -1e-3 1e-4 -2e-4 3e-4]));
P = transl2(1, 2) * trot2(30, 'deg');  at = transl2(P);  R2 = rot2(pi / 6);
[s, sd, sdd] = tpoly(1, 3, 0:0.1:2, 0.5, -0.2);
[l, ld, ldd] = lspb(1, -2, 0:0.1:4);
[m, md] = mtraj(@lspb, [0 5], [2 -1], 51);
save('-v7', 's21.mat');
