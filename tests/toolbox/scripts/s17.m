% Lines, held, with styles and a legend; limits and an equal scale.
x = linspace(0, 2 * pi, 40)';
figure(170); plot(x, sin(x), 'r-', x, cos(x), 'b--o'); hold on; plot(x, 0 * x, 'k:'); hold off
legend('sin', 'cos', 'zero'); axis equal; xlim([0 7]); title({'two lines', 'of title'})
h = plot(x, sin(x).^2); set(h, 'LineWidth', 3, 'Color', [0 0.5 0])
save('-v7', 's17.mat', 'x')
