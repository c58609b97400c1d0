% Torques along a path.
puma560
t = linspace(0, 1.5, 16)';
[q, qd, qdd] = jtraj(qz, qn, t);
tau = rne(p560, q, qd, qdd);
same = rne(p560, [q qd qdd]);
figure(40); plot(t, tau(:, 1:3)); legend('joint 1', 'joint 2', 'joint 3', 'Location', 'southeast')
save('-v7', 's04.mat', 'q', 'qd', 'qdd', 'tau', 'same')
