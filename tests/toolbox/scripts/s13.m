% Frames by hand: rotations, roll, pitch and yaw, Euler's angles.
T = transl(1, 2, 3) * trotx(0.3) * troty(-0.2) * trotz(90, 'deg');
rpy = tr2rpy(rpy2tr(0.1, 0.2, 0.3)); eul = tr2eul(eul2tr([0.1 0.2 0.3]));
half = trinterp(eye(4), trotz(1.0), 0.5);
save('-v7', 's13.mat', 'T', 'rpy', 'eul', 'half')
