% The same arm in the order theta, d, a, alpha.
L(1) = Link([0 0     0.150  pi/2]);
L(2) = Link([0 0     0.570  0]);
L(3) = Link([0 0     0.130  pi/2]);
L(4) = Link([0 0.640 0     -pi/2]);
L(5) = Link('d', 0, 'a', 0, 'alpha', pi/2);
L(6) = Revolute('d', 0.095, 'a', 0, 'alpha', 0);
up6 = SerialLink(L, 'name', 'UP6');
q = [0.1 0.9 0.2 -0.4 0.5 0.6];
T = up6.fkine(q);
n = up6.n;
up6.tool = transl(0, 0, 0.1);
Tt = up6.fkine(q);
save('-v7', 's09.mat', 'q', 'T', 'n', 'Tt')
