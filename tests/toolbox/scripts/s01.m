% Direct kinematics of the Puma at its named postures.
clear all; close all; clc
puma560
Tz = fkine(p560, qz); Tr = fkine(p560, qr); Tn = p560.fkine(qn);
save('-v7', 's01.mat', 'Tz', 'Tr', 'Tn')
