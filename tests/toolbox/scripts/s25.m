% Motion under torques: a rod that dry friction stops, and a Puma with all its friction, held in part by a spring.
rod = SerialLink(Link([0 0 1 0]), 'name', 'rod');
rod.links(1).m = 2; rod.links(1).r = [-0.5 0 0]; rod.links(1).Tc = [0.5 -0.5];
rod.gravity = [0 0 0];
[t1, q1, qd1] = rod.fdyn(1.4, [], 0, 1);
mdl_puma560
spring = @(r, t, q, qd, k) -k * [0 1 1 0 0 0] .* (q - qn);
[t2, q2, qd2] = p560.fdyn(0.3, spring, qr, zeros(1, 6), 20);
L = p560.links; G = [L.G]; B = [L.B]; Tc = reshape([L.Tc], 2, 6);
old = @(t, q, qd) -20 * [0 1 1 0 0 0] .* (q - qn);
[t3, q3] = fdyn(p560, 0, 0.02, old, qr, zeros(1, 6));
[t4, q4] = p560.fdyn(0.02, spring, qr, [], 20);
rows = accel(p560, [qn; qr], ones(2, 6), zeros(2, 6));
stacked = accel(p560, [qn ones(1, 6) zeros(1, 6)]);
single = p560.accel(qr, ones(1, 6), zeros(1, 6));
clear spring old rod p560 L
save('-v7', 's25.mat');
