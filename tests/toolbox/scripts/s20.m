% Motion under gravity alone, and its energy.
twolink
[t, q, qd] = fdyn(tl, 0, 0.03, '', [0.1 0.2], [0 0]);
figure(200); plot(t, q); print('-dpng', 'swing.png')
h = zeros(size(t)); k = h;
for i = 1:numel(t)
  k(i) = 0.5 * qd(i, :) * inertia(tl, q(i, :)) * qd(i, :)';
end
save('-v7', 's20.mat', 't', 'q', 'qd', 'k')
