% The workspace of a planar arm.
twolink
n = 7; xy = [];
for a = linspace(-pi/2, pi/2, n)
  for b = linspace(-2, 2, n)
    p = transl(fkine(tl, [a b])); xy = [xy; p(1:2)'];
  end
end
figure(180); plot(xy(:, 1), xy(:, 2), '.'); axis equal; title('ワークスペース'); xlabel('x [m]'); ylabel('y [m]')
save('-v7', 's18.mat', 'xy')
