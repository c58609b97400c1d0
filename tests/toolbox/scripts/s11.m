% An arm that slides: cylinder coordinates.
L = {link([0 0 0 0.4 0]), link([-pi/2 0 0 0 1]), link([0 0 0 0 1])};
r = robot(L, 'cylinder');
T = fkine(r, [pi/3 0.2 0.5]);
J = jacob0(r, [pi/3 0.2 0.5]);
kinds = r.config;
save('-v7', 's11.mat', 'T', 'J', 'kinds')
