"""Modules of the worlds that are digested: they use only the interface of mjsim."""

import math

import numpy as np

import mjsim


class Steps:
    """A navigator that drives a fixed table of twists, and reports to the other robots what it does."""

    def __init__(self, *, speed=0.4, left=0.0, turn=0.8, wheels=False, talks=False):
        """Keep how fast it goes [m/s, m/s, rad/s], and whether it commands wheels, and whether it sends messages."""
        self._speed, self._left, self._turn, self._wheels, self._talks = speed, left, turn, wheels, talks

    def start(self, robot, map, rng):
        """Begin with the first twist."""
        self._robot, self._rng = robot, rng

    def command(self, seen, belief):
        """Return straight ahead, an arc to the left, backwards, an arc to the right, and so on, for one second each."""
        phase = int(seen.time) % 4
        forward = self._speed * (-1.0 if phase == 2 else 1.0)
        turn = self._turn * (0.0, 1.0, 0.0, -1.0)[phase]
        if self._wheels:
            speed = forward / self._robot.wheel_radius
            return mjsim.WheelCommand(tuple(speed * (1.0 + 0.1 * k) for k in range(len(self._robot.wheels))))
        heard = [message.text for message in seen.messages]
        messages = ({"at": seen.time, "heard": len(heard), "luck": self._rng.random()},) if self._talks else ()
        return mjsim.Command(forward, self._left * math.sin(seen.time), turn, messages)


class Everything:
    """An estimator whose innovations depend on all of its inputs, so that any change of these shows."""

    def start(self, robot, catalogue, rng):
        """Begin at the prior."""
        self._pose = robot.prior
        self._told = [float(np.sum(info.robot_from_sensor)) for info in robot.sensors.values()]

    def update(self, seen):
        """Return dead reckoning."""
        moved = seen.odometry
        self._pose = self._pose @ mjsim.Pose(moved.forward, moved.left, moved.turn)
        numbers = {"sensors": sum(self._told), "sightings": sum(each.range for each in seen.sightings)}
        numbers |= {name: float(np.sum(frame.image)) for name, frame in seen.cameras.items()}
        numbers |= {
            f"{name}/depth": float(np.sum(frame.depth[np.isfinite(frame.depth)]))
            for name, frame in seen.cameras.items()
            if frame.depth is not None
        }
        numbers |= {name: float(np.sum(scan.ranges[np.isfinite(scan.ranges)])) for name, scan in seen.scans.items()}
        for reading in seen.imu:
            numbers[reading.name] = float(np.sum(reading.acceleration) + np.sum(reading.turn))
        S = np.eye(2)
        return mjsim.Estimate(
            pose=self._pose,
            covariance=np.eye(3) * 1e-4,
            innovations=tuple((name, np.array([value, 0.0]), S) for name, value in numbers.items()),
        )


class Tank:
    """A drive of the user's own: two wheels, one on each side."""

    wheels = ("left", "right")

    def __init__(self, radius, track):
        """Keep the radius of the wheels and the distance between them [m]."""
        self.radius, self.track = radius, track

    def wheels_from_twist(self, forward, left, turn):
        """Return the speeds of both wheels [rad/s]."""
        half = turn * self.track / 2
        return (forward - half) / self.radius, (forward + half) / self.radius

    def twist_from_wheels(self, speeds):
        """Return the twist of both speeds."""
        left, right = speeds
        return self.radius * (left + right) / 2, 0.0, self.radius * (right - left) / self.track
