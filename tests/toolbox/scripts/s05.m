% Gravity load over two joints as a surface.
puma560
[a, b] = meshgrid(-pi:pi/3:pi, -pi:pi/3:pi);
g = zeros(size(a));
for i = 1:rows(a)
  for k = 1:columns(a)
    load_ = gravload(p560, [0 a(i, k) b(i, k) 0 0 0]);
    g(i, k) = load_(2);
  end
end
figure(50); surf(a, b, g); xlabel('q2'); ylabel('q3'); zlabel('torque'); colorbar
save('-v7', 's05.mat', 'a', 'b', 'g')
