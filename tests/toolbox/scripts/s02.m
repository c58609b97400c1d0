% A joint path and its three curves, one above the other.
puma560
t = 0:0.05:2;
[q, qd, qdd] = jtraj(qz, qr, t);
figure(20)
subplot(3, 1, 1); plot(t, q(:, 2)); ylabel('\theta_2 [rad]'); title('joint 2')
subplot(3, 1, 2); plot(t, qd(:, 2), 'r--'); ylabel('rate'); grid on
subplot(3, 1, 3); plot(t, qdd(:, 2), 'k', 'LineWidth', 2); xlabel('time [s]'); grid
save('-v7', 's02.mat', 't', 'q', 'qd', 'qdd')
