% Inertia at the shoulder for an outstretched and a folded arm.
puma560
Mn = inertia(p560, qn); Mz = p560.inertia(qz);
C = coriolis(p560, qn, 0.3 * ones(1, 6));
save('-v7', 's06.mat', 'Mn', 'Mz', 'C')
