% Computed torque control, integrated with small steps.
twolink
dt = 0.02; t = 0:dt:1;
[qr, qdr, qddr] = jtraj([0 0], [1 -0.5], t);
q = [0.1 0]; qd = [0 0]; log_ = zeros(numel(t), 2);
for k = 1:numel(t)
  e = qr(k, :) - q; ed = qdr(k, :) - qd;
  tau = rne(tl, q, qd, qddr(k, :) + 20 * ed + 100 * e);
  qdd = accel(tl, q, qd, tau)';
  qd = qd + dt * qdd; q = q + dt * qd;
  log_(k, :) = e;
end
figure(150); plot(t, log_); title('error of the joints'); legend({'joint 1', 'joint 2'}); xlabel('t [s]')
last = log_(end, :);
save('-v7', 's15.mat', 'last')
