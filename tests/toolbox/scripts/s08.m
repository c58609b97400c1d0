% A six-axis arm of industry from its table, in the order alpha, a, theta, d.
L1 = link([ pi/2 0.150 0 0.000 0], 'standard');
L2 = link([ 0    0.570 0 0.000 0], 'standard');
L3 = link([ pi/2 0.130 0 0.000 0], 'standard');
L4 = link([-pi/2 0.000 0 0.640 0], 'standard');
L5 = link([ pi/2 0.000 0 0.000 0], 'standard');
L6 = link([ 0    0.000 0 0.095 0], 'standard');
up6 = robot({L1 L2 L3 L4 L5 L6}, 'UP6');
q = [0.1 0.9 0.2 -0.4 0.5 0.6];
T = fkine(up6, q);
back = ikine(up6, T, zeros(1, 6));
again = fkine(up6, back);
figure(80); plot(up6, q)
save('-v7', 's08.mat', 'q', 'T', 'again')
