% Jacobians in the world and in the tool.
puma560
J0 = jacob0(p560, qn); Jn = jacobn(p560, qn);
rates = J0 * [0.1; 0.2; 0; 0; 0; 0.3];
m = maniplty(p560, qn);
save('-v7', 's07.mat', 'J0', 'Jn', 'rates', 'm')
