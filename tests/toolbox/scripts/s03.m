% A straight path of the tool, and the joints that follow it.
puma560
T0 = transl(0.6, -0.5, 0.0); T1 = transl(0.4, 0.5, 0.2);
T = ctraj(T0, T1, 6);
q = ikine(p560, T, [0 0 0 0 0 0]);
reached = fkine(p560, q);
figure(30); plot3(squeeze(T(1, 4, :)), squeeze(T(2, 4, :)), squeeze(T(3, 4, :)), 'b.-')
xlabel('x'); ylabel('y'); zlabel('z'); grid on; title('path of the tool')
save('-v7', 's03.mat', 'T', 'q', 'reached')
