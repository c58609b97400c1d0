% Functions at the end, handles whose data move, two scales, and images.
clear all; close all
figure(230); h = plot(0, 0, 'b', 0, 0, 'r.'); body = patch(0, 0, 'g');
for k = 1:3
  set(h(1), 'xdata', 1:k); set(h(1), 'ydata', squares(1:k)); set(body, 'xdata', k + [0 1 0], 'ydata', [0 0 1]);
  drawnow
end
figure(231); upper = subplot(2, 1, 1); lower = subplot(2, 1, 2); plot(upper, 1:3); title(lower, 'below'); title(upper, 'above');
[ax, left, right] = plotyy(1:3, 1:3, 1:3, [10 20 30]); ylabel(ax(2), 'right');
figure(232); imagesc(magic(4)); axis xy; colormap(gray); [n, c] = hist([1 1 2.5 5], 4);
figure(233); tiledlayout(1, 2); nexttile; imshow(uint8(255 * eye(3))); nexttile; scatter([1 2], [3 4], [10 90], 'filled');
save('-v7', 's23.mat', 'n', 'c')
function y = squares(x)
  y = x .^ 2; % an 'end' in a comment, and x(end) below
  if y(end) < 0, y = y(1:end); end
end
