function [tau, state] = hold_upright(fast, wanted, robot, state)
% HOLD_UPRIGHT  Torques of the left and the right wheel [N m] that hold a balancing base upright and follow commands.
%
% State feedback by a linear quadratic regulator, designed at the first call from the robot's parameters. The pitch is
% integrated from the gyroscope, with slow correction by the accelerometer.
%
% F. Grasser et al., JOE: A Mobile, Inverted Pendulum, IEEE Transactions on Industrial Electronics 49(1), 2002.
base = robot.balancing;
radius = robot.wheel_radius;
track = robot.track;
if isempty(state)
    [A, B] = upright_model(base, radius);
    state.push = regulator(A, B, diag([20 20 5 2]), 0.2, fast.dt);
    rolling = base.wheel_mass + base.wheel_inertia / radius^2;
    inertia = base.yaw_inertia + 2 * (base.wheel_across + rolling * (track / 2)^2);
    state.twist = regulator([0 1; 0 0], [0; track / (2 * radius) / inertia], diag([20 2]), 0.2, fast.dt);
    f = fast.imu(2:4, end);
    state.pitch = atan2(-f(1), f(3));
    state.stamp = fast.imu(1, end);
    state.speed = 0;
    state.way = radius * (mean(fast.wheels.q) + state.pitch);
    state.heading = radius * (fast.wheels.q(2) - fast.wheels.q(1)) / track;
end
spin = radius * mean(fast.wheels.qd);
rate = fast.imu(6, end);
speed = spin + radius * rate;
for k = 1:size(fast.imu, 2)
    dt = fast.imu(1, k) - state.stamp;
    if dt > 0
        gained = (speed - state.speed) / fast.dt;
        leans = asin(max(-1, min(1, (gained - fast.imu(2, k)) / 9.81)));
        state.pitch = state.pitch + dt * (fast.imu(6, k) + 0.3 * (leans - state.pitch));
        state.stamp = fast.imu(1, k);
    end
end
state.speed = speed;
way = radius * (mean(fast.wheels.q) + state.pitch);
heading = radius * (fast.wheels.q(2) - fast.wheels.q(1)) / track;
turn = radius * (fast.wheels.qd(2) - fast.wheels.qd(1)) / track;
push = -state.push * [way - state.way; state.pitch; speed - wanted.forward; rate];
twist = -state.twist * [heading - state.heading; turn - wanted.turn];
state.way = near(state.way + wanted.forward * fast.dt, way, 0.6);
state.heading = near(state.heading + wanted.turn * fast.dt, heading, 1);
push = near(push, 0, 2 * base.max_torque);
twist = near(twist, 0, 2 * base.max_torque - abs(push));
tau = [push - twist; push + twist] / 2;
end

function [A, B] = upright_model(base, radius)
% Return x' = A x + B u for distance, pitch and their rates; u is the sum of both motor torques.
m = base.body_mass;
h = base.center;
whole = m + 2 * base.wheel_mass + 2 * base.wheel_inertia / radius^2;
M = [whole, m * h; m * h, base.pitch_inertia + m * h^2];
A = [zeros(2), eye(2); zeros(2, 4)];
B = zeros(4, 1);
A(3:4, 2) = M \ [0; m * 9.81 * h];
B(3:4) = M \ [1 / radius; -1];
end

function K = regulator(A, B, Q, R, dt)
% Return the feedback gain of the sampled model, by iterating the Riccati equation until it converges.
n = size(A, 1);
both = expm([A, B; zeros(1, n + 1)] * dt);
A = both(1:n, 1:n);
B = both(1:n, n + 1);
P = Q;
for k = 1:100000
    K = (R + B' * P * B) \ (B' * P * A);
    next = Q + A' * P * (A - B * K);
    if norm(next - P, 1) < 1e-10 * norm(P, 1)
        break
    end
    P = next;
end
end

function value = near(value, middle, most)
% Return the value closest to a wanted one within a maximum distance from a centre.
value = max(middle - most, min(middle + most, value));
end
