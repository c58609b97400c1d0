% Bode magnitude of a joint on logarithmic axes.
w = logspace(-1, 2, 60); g = abs(10 ./ ((1i * w) .* (1i * w + 5)));
figure(160); subplot(211); loglog(w, g, 'b'); grid on; subplot(212); semilogx(w, -90 - atan(w / 5) * 180 / pi, 'm-.')
axis([0.1 100 -190 -80]); text(1, -120, 'phase')
save('-v7', 's16.mat', 'w', 'g')
