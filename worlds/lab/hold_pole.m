function [force, state] = hold_pole(fast, wanted, robot, state)
% HOLD_POLE  Force on the cart [N] that balances its pole and moves the cart to its goal.
%
% State feedback u = -K x, by Ackermann's formula at the first call; x contains the deviations of position and angle
% from their goals, and their rates [m, rad, m/s, rad/s].
%
% K. Ogata, Modern Control Engineering, 5th edition (2010), section 10.2.
if isempty(state)
    [A, B] = upright_pole(robot.options);
    state.K = placed(A, B, robot.options.poles);
end
x = fast.joints.x;
q = fast.joints.q;
force = -state.K * [x.q - wanted.joints.x.q; q.q + pi / 2; x.qd; q.qd];
end

function [A, B] = upright_pole(given)
% Return x' = A x + B u of a cart with a pole about upright; masses in kg, the pole's length and radius in m.
m = given.pole;
h = given.length / 2;
inertia = m * (given.length^2 / 12 + given.radius^2 / 4);
M = [given.cart + m, m * h; m * h, inertia + m * h^2];
A = [zeros(2), eye(2); zeros(2, 4)];
B = zeros(4, 1);
A(3:4, 2) = M \ [0; m * 9.81 * h];
B(3:4) = M \ [1; 0];
end

function K = placed(A, B, poles)
% Return the feedback gain that places the poles of A - B K.
n = size(A, 1);
reach = zeros(n);
for k = 1:n
    reach(:, k) = A^(k - 1) * B;
end
K = [zeros(1, n - 1), 1] / reach * polyvalm(poly(poles), A);
end
