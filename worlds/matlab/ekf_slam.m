function [est, state] = ekf_slam(obs, robot, state)
% EKF_SLAM  Joint Gaussian estimate of the pose and a map of named beacons, from odometry, range and bearing.
%
% robot.options.gate    maximum squared Mahalanobis distance of a sighting; default: no gate
% robot.options.joint   true to return the joint covariance, for the map statistics of the report
%
% S. Thrun, W. Burgard, D. Fox, Probabilistic Robotics, 2005, table 10.1, with the covariances of this robot.
if isempty(state)
    state.x = robot.prior;               % pose, then (x, y) of each landmark
    state.P = robot.prior_covariance;
    state.ids = zeros(1, 0);             % which beacon each landmark is
    state.gate = option(robot, 'gate', Inf);
    state.joint = option(robot, 'joint', false);
end
state = predict(state, obs.odometry);
if any(obs.id)
    named = find(obs.id);
    [is_known, place] = ismember(obs.id(named), state.ids);
    known = named(is_known);
    [state, nu, S, counts] = correct(state, place(is_known), obs.z(:, known), obs.R(:, :, known));
    for k = named(~is_known)
        state = add(state, obs.id(k), obs.z(:, k), obs.R(:, :, k));
    end
    est.innovations = nu(:, counts);
    est.innovation_covariance = S(:, :, counts);
    est.innovation_ids = obs.id(known(counts));
end
est.pose = state.x(1:3);
est.covariance = state.P(1:3, 1:3);
[est.landmarks, est.landmark_covariance] = map_of(state);
est.ids = state.ids;
if state.joint
    est.joint_covariance = state.P;
end
end

function state = predict(state, u)
% Predict the pose by odometry, which is in the robot's frame.
c = cos(state.x(3));
s = sin(state.x(3));
d = [c -s; s c] * [u.forward; u.left];
F = [1 0 -d(2); 0 1 d(1); 0 0 1];
G = [c -s 0; s c 0; 0 0 1];
state.x(1:2) = state.x(1:2) + d;
state.x(3) = wrap(state.x(3) + u.turn);
state.P(1:3, 1:3) = F * state.P(1:3, 1:3) * F' + G * u.covariance * G';
state.P(1:3, 4:end) = F * state.P(1:3, 4:end);
state.P(4:end, 1:3) = state.P(1:3, 4:end)';
end

function [state, nu, S, counts] = correct(state, places, z, R)
% Correct by the sightings of mapped landmarks, all simultaneous ones together.
k = numel(places);
n = numel(state.x);
nu = zeros(2, k);
S = zeros(2, 2, k);
H = zeros(2 * k, n);
for j = 1:k
    at = 2 + 2 * places(j);              % where the landmark's x stands in the state
    dx = state.x(at) - state.x(1);
    dy = state.x(at + 1) - state.x(2);
    q = dx * dx + dy * dy;
    r = sqrt(q);
    rows = 2 * j - 1:2 * j;
    H(rows, [1:3 at at + 1]) = [-dx / r, -dy / r, 0, dx / r, dy / r; dy / q, -dx / q, -1, -dy / q, dx / q];
    nu(:, j) = [z(1, j) - r; wrap(z(2, j) - atan2(dy, dx) + state.x(3))];
end
HP = H * state.P;
HPH = HP * H';
counts = true(1, k);
for j = 1:k
    rows = 2 * j - 1:2 * j;
    S(:, :, j) = HPH(rows, rows) + R(:, :, j);
    counts(j) = nu(:, j)' * (S(:, :, j) \ nu(:, j)) < state.gate;
end
if ~any(counts)
    return
end
rows = find(reshape([counts; counts], 1, []));
noise = zeros(2 * k);
for j = find(counts)
    noise(2 * j - 1:2 * j, 2 * j - 1:2 * j) = R(:, :, j);
end
L = chol(HPH(rows, rows) + noise(rows, rows), 'lower');
W = L \ HP(rows, :);                     % P H' S^-1 H P = W' W, which is symmetric to the last bit
state.x = state.x + W' * (L \ reshape(nu(:, counts), [], 1));
state.x(3) = wrap(state.x(3));
state.P = state.P - W' * W;
end

function state = add(state, id, z, R)
% Append a new landmark to the state.
c = cos(state.x(3) + z(2));
s = sin(state.x(3) + z(2));
d = z(1) * [c; s];
J_pose = [1 0 -d(2); 0 1 d(1)];
J = [c, -d(2); s, d(1)];
cross = J_pose * state.P(1:3, :);
own = J_pose * state.P(1:3, 1:3) * J_pose' + J * R * J';
state.P = [state.P, cross'; cross, (own + own') / 2];
state.x = [state.x; state.x(1:2) + d];
state.ids = [state.ids, id];
end

function [means, covariances] = map_of(state)
% Return landmarks, 2 x n, and their covariances, 2 x 2 x n.
n = numel(state.ids);
means = reshape(state.x(4:end), 2, n);
size_of = numel(state.x);
first = (0:n - 1) * 2 * (size_of + 1) + 3 * (size_of + 1) + 1;   % where each 2 x 2 block begins in P
covariances = reshape(state.P([first; first + 1; first + size_of; first + size_of + 1]), 2, 2, n);
end

function value = option(robot, name, value)
% Return an option, or its default.
if isfield(robot.options, name)
    value = robot.options.(name);
end
end

function angle = wrap(angle)
% Return an angle wrapped to [-pi, pi) [rad].
angle = mod(angle + pi, 2 * pi) - pi;
end
