% The arm in motion, posture by posture.
twolink
hold off
figure(140)
[q, qd] = jtraj([0 0], [pi/2 -pi/3], 8);
for k = 1:rows(q)
  plot(tl, q(k, :)); drawnow; pause(0.01)
end
save('-v7', 's14.mat', 'q', 'qd')
