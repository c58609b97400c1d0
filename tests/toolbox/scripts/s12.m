% The modified convention.
L = {link([0 0 0 0.3 0], 'modified'), link([-pi/2 0.1 0 0 0], 'modified'), link([0 0.5 0 0.1 0], 'modified')};
for k = 1:3
  L{k}.m = k; L{k}.r = [0.1 0.02 * k 0.03]; L{k}.I = diag([0.1 0.2 0.3]);
end
r = robot(L);
q = [0.2 -0.3 0.4]; qd = [0.5 0.6 -0.7]; qdd = [1 -2 3];
T = fkine(r, q); J = jacob0(r, q);
tau = rne(r, q, qd, qdd); M = inertia(r, q);
save('-v7', 's12.mat', 'q', 'qd', 'qdd', 'T', 'J', 'tau', 'M')
