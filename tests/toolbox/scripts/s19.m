% The old names: a matrix instead of an arm, arguments in the other order, plotbot, drivebot.
dh = [0 1 0 0 0; 0 0.5 0 0 0];
T = fkine(dh, [0.1 0.2]);
r = robot(dh, 'by matrix');
S = fkine([0.1 0.2], r);
q = ikine(r, T, [0.3 0.3], [1 1 0 0 0 0]);
figure(190); plotbot(r, q)
drivebot(r, q)
save('-v7', 's19.mat', 'T', 'S', 'q')
