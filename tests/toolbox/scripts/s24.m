% What a figure tells: limits, data of its lines, and arms with a payload, friction and limits of their joints.
close all
figure(240)
h = plot([0 1.5], [-0.9 0.9]);
v = axis;
h.LineWidth = 2;
x = get(h, 'XData');
set(h, 'YData', [1 2]);
y = h.YData;
xlim([0 3]);
w = axis();
print -depsc told.eps
figure; f = figure;
fplot(@(x) x .^ 2, [0 2]); fplot(@tan, [0 1]); ezplot(@sin); ezplot('x^2 + y^2 - 1');
r = robot({link([0 1 0 0 0]), link([0 1 0 0 0])}, 'plane');
r.gravity = [0 9.81 0];
r.link{1}.m = 1; r.link{1}.r = [-0.5 0 0];
payload(r, 2, [0 0 0]);
g = gravload(r, [0 0]);
r.link{2}.B = 0.5; r.link{2}.G = 2; r.link{2}.Tc = [0.3 -0.3];
b = friction(r, [1 -2]);
dyn(r)
T = r.A(1:2, [0.3 0.4]) - r.fkine([0.3 0.4]);
mdl_puma560
p560.qlim = repmat([-3 3], 6, 1);
q = p560.ikcon(p560.fkine(qn));
miss = p560.fkine(q) - p560.fkine(qn);
mdl_twolink
[t, qs] = twolink.nofriction().fdyn(0.01, [], [0 0]);
save('-v7', 's24.mat');
