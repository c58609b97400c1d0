% A planar arm of two links, and its closed form.
L{1} = link([0 1 0 0 0]); L{2} = link([0 0.7 0 0 0]);
L{1}.m = 2; L{2}.m = 1; L{1}.r = [-0.5 0 0]; L{2}.r = [-0.35 0 0];
L{2}.I = [0 0 0.1 0 0 0];
r = robot(L, 'planar');
r.gravity = [0 9.81 0];
q = [0.3 0.5]; qd = [0.2 -0.4]; qdd = [1 2];
p = transl(fkine(r, q));
tau = rne(r, q, qd, qdd);
g = gravload(r, q);
save('-v7', 's10.mat', 'p', 'tau', 'g')
