% Closed forms of the Puma, straight lines with blends, and frames.
mdl_puma560
T = p560.fkine(qn);
left = p560.ikine6s(T); right = p560.ikine6s(T, 'ru');
all_ = zeros(8, 6); k = 0;
Tk = p560.fkine([0.3 -0.4 0.5 0.6 -0.7 0.8]);
for s = 'lr', for e = 'ud', for w = 'nf', k = k + 1; all_(k, :) = p560.ikine6s(Tk, [s e w]); end, end, end
reached = p560.fkine(all_);
[p, t] = mstraj([1 0; 1 1], [1 2], [], [0 0], 0.05, 0.2);
R = trexp(trlog(Tk)); S = trnorm(Tk); J = eul2jac(0.3, 0.5, 0.7); W = wtrans(Tk, [1 2 3 4 5 6]');
a = tr2rpy(Tk, 'deg'); moved = homtrans(Tk, [1 2; 3 4; 5 6]);
figure(220); trplot(Tk, 'frame', 'A', 'color', 'r', 'length', 0.2); figure(221); tranimate(Tk, 'nsteps', 10)
[t2, q2] = fdyn(nofriction(p560, 'all'), 0.005, @(varargin) zeros(1, 6), qn, zeros(1, 6));
save('-v7', 's22.mat', 'left', 'right', 'Tk', 'reached', 'all_', 'p', 't', 'R', 'S', 'J', 'W', 'a', 'moved', 'q2')
