function [cmd, state] = drive_route(obs, est, robot, state)
% DRIVE_ROUTE  Drive from point to point repeatedly: turn towards the next one, drive faster when it is ahead.
%
% robot.options.points  n x 2, in the frame of the estimate [m]
% robot.options.speed   speed on straight lines [m/s]; default 0.5
% robot.options.near    distance at which a point counts as reached [m]; default 0.4
if isempty(state)
    state.next = 1;
    state.speed = 0.5;
    state.near = 0.4;
    if isfield(robot.options, 'speed')
        state.speed = robot.options.speed;
    end
    if isfield(robot.options, 'near')
        state.near = robot.options.near;
    end
end
points = robot.options.points;
to = points(state.next, :)' - est.pose(1:2);
if norm(to) < state.near
    state.next = mod(state.next, size(points, 1)) + 1;
    to = points(state.next, :)' - est.pose(1:2);
end
off = mod(atan2(to(2), to(1)) - est.pose(3) + pi, 2 * pi) - pi;
cmd.forward = min(state.speed, robot.max_speed) * max(0, cos(off))^3;
cmd.turn = max(-robot.max_turn, min(robot.max_turn, 1.5 * off));
end
