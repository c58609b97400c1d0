"""The built-in obstacle avoidance, based on the ring of proximity rays; it prefers unvisited directions."""

import math
from dataclasses import replace

import numpy as np
from numpy.random import Generator

from mjsim.geometry import Array, wrap_angle
from mjsim.interface import Command, Observation, RobotInfo
from mjsim.safety.body_outline import is_round, rim
from mjsim.safety.footprint import MAX_TOUCHING_DISTANCE, MIN_CLEARANCE, Footprint
from mjsim.safety.hits import RAYS, Hits
from mjsim.sentences import Sentence


class RingAvoidance:
    """Avoids obstacles detected by the ring of proximity rays, with minimal changes of the command.

    Points hit by the rays are remembered for some seconds (`Hits`). A command whose arc is free is not changed.
    Otherwise, among arcs with turn rates around the commanded one, within the steering limits, it selects the one that
    keeps most of the speed, then most of the turn. Speed is limited so that the robot can stop before the nearest point
    on its arc, and lower when it passes close to something. It can always stop within a part of the free space that the
    rays currently measure ahead, because the obstacle may be another robot driving towards it. While passing an
    obstacle it keeps to the chosen side, even if it is commanded to turn back on the spot towards the obstacle.

    If there is no free path ahead, the robot turns on the spot to a free direction, preferably one where it has been
    least (`Trail`), so that it leaves dead ends and does not drive in circles. A robot that cannot do so, or has no
    room for it, moves backward and forward in strokes, turning its front towards that direction. A robot commanded to
    move sideways moves straight in the free direction closest to the commanded one, within 81 degrees, and keeps its
    turn rate; if there is none, it stops.

    References:
        Fox, Burgard, Thrun, The Dynamic Window Approach to Collision Avoidance, IEEE RAM 4(1), 1997: arcs, and speeds
        that allow a stop. Remembered points, keeping to a side and escape manoeuvres are our own.
    """

    HORIZON = 1.6
    """Lookahead time along an arc [s]; longer if stopping takes longer."""
    NEAREST = 0.6
    """Minimum lookahead distance [m]."""
    TURN = 1.2
    """Turn rate of the sharpest arc; lower for a longer lookahead [rad/s]."""
    MAX_CLEARANCE = 0.5
    """Maximum of the argument `clearance` [m]."""
    SIGHT = 2.0
    """Default range of the rays [m]; the speed always allows a stop within it."""
    OWN = 0.6
    """Part of the free space ahead in which the robot can stop on any arc, so that two approaching robots do not
    collide."""
    AHEAD = 0.3
    """A ray counts as ahead if the cosine of its angle to the direction of motion exceeds this."""
    SLENDER = 3.0
    """Robots that extend farther from their origin, in half widths, do not turn on the spot: the rear swings out."""
    HOLD = 1.5
    """Time for which a side is kept after passing an obstacle [s]."""
    MAX_HOLD = 30.0
    """Time of passing one obstacle after which a command to turn back is allowed [s]."""
    STROKE = 1.5
    """Duration of a stroke backward or forward, if there is no room to turn on the spot [s]."""
    ROLLS = 0.02
    """Speeds below this count as standing still [m/s]."""

    def __init__(self, *, clearance: float = MIN_CLEARANCE, lidar: str | None = None) -> None:
        """Set the clearance and an additional sensor.

        Args:
            clearance: Minimum distance between the rim of the robot and hits of the rays on a free path [m]. Increase
                it for obstacles that extend above or below the rays: feet of people, table tops.
            lidar: Name of a lidar of the robot that is used too: legs are thin enough to be missed between two rays.

        Raises:
            ValueError: The clearance is less than the default, or more than the rays can reliably measure.
        """
        if not MIN_CLEARANCE <= clearance <= self.MAX_CLEARANCE:
            raise ValueError(
                Sentence(
                    "clearance is {clearance} m; it must be from {min_clearance} to {max_clearance}",
                    clearance,
                    MIN_CLEARANCE,
                    self.MAX_CLEARANCE,
                )
            )
        self._clearance, self._lidar = clearance, lidar

    def start(self, robot: RobotInfo, rng: Generator) -> None:
        """Reset, and take the shape and the limits of the robot."""
        self._robot, self._rng = robot, rng
        self._robot_from_lidar = None if self._lidar is None else _mounting(robot, self._lidar)
        self._body = Footprint(robot, clearance=self._clearance)
        self._spins = math.isinf(robot.max_curvature) and self._body.slender < self.SLENDER
        # A steering angle far from straight takes time to return.
        self._bend = robot.max_curvature if self._spins else min(robot.max_curvature, 1.0 / robot.radius)
        # The robot keeps space to turn on the spot, unless it cannot do that or would need too much space.
        self._swing = Footprint(robot, clearance=self._clearance, swing=True) if self._spins else self._body
        self._deceleration = 0.5 * robot.max_acceleration
        rims = np.full(RAYS, robot.radius)
        if robot.outline is not None and not is_round(robot.outline):
            rims = np.array([rim(robot.outline, 2.0 * math.pi / RAYS * ray) for ray in range(RAYS)])
        self._hits, self._trail = Hits(rims, join=0.0 if self._body.round else self._body.width), Trail()
        self._ring: Array = np.full(RAYS, np.inf)
        self._cosines: Array = np.cos(np.arange(RAYS) * (2.0 * math.pi / RAYS))
        self._fan: Array = np.linspace(-1.0, 1.0, 13)
        if not self._swing.round:
            # A long body can leave a wall only gradually, because its tail swings towards the wall.
            self._fan = self._fan * np.abs(self._fan)
        self._bearings: Array = np.arange(-11.0, 13.0) * (math.pi / 12)
        self._speed = 0.0
        self._side, self._met_at, self._held = 0.0, -math.inf, -math.inf
        self._heading: float | None = None
        self._pace, self._stroke, self._left = 0.0, 0.0, 0

    def adjust(self, command: Command, seen: Observation) -> Command:
        """Return the safe command closest to the one given."""
        self._hits.see(seen)
        self._see_scan(seen)
        self._ring, self._pace = seen.proximity, seen.odometry.forward / seen.dt
        self._trail.add(self._hits.x, self._hits.y)
        if command.left:
            self._forget()
            return self._sidestep(command)
        if abs(command.forward) > 1e-9:
            self._speed = command.forward
            return self._drive(command, seen.time)
        if command.turn and self._goes_round(command.turn, seen.time):
            return self._drive(replace(command, forward=self._speed), seen.time, if_free=command)
        self._forget()
        if not command.turn or self._body.can_spin(self._points(0.0, 0.0), command.turn):
            return command
        return replace(command, turn=0.0)

    def _see_scan(self, seen: Observation) -> None:
        """Store the hits of the lidar, if one is used."""
        if self._lidar is None or self._robot_from_lidar is None or self._lidar not in seen.scans:
            return
        hits = seen.scans[self._lidar].points()
        self._hits.add(hits @ self._robot_from_lidar[:2, :2].T + self._robot_from_lidar[:2, 3], seen.time)

    def _forget(self) -> None:
        """Forget the obstacle that was being passed."""
        self._side, self._heading, self._stroke = 0.0, None, 0.0

    def _goes_round(self, turn: float, now: float) -> bool:
        """Return whether a turn on the spot would lead back to the obstacle being passed."""
        if now - self._held > self.HOLD or now - self._met_at > self.MAX_HOLD:
            return False
        return self._heading is not None or self._stroke != 0.0 or turn * self._side < 0.0

    def _points(self, speed: float, seconds: float) -> Array:
        """Return the points that a path could come close to, robot's frame, shape (n, 2) [m]."""
        return self._hits.within(speed * seconds + self._body.radius + self._body.roomy)

    def _drive(self, command: Command, now: float, *, if_free: Command | None = None) -> Command:
        """Return the closest free arc; or an escape manoeuvre if there is none.

        Args:
            command: Command that drives forward or backward.
            now: [s]
            if_free: Result if nothing is in the way; by default the command itself.
        """
        direction, speed = math.copysign(1.0, command.forward), abs(command.forward)
        speed = min(speed, math.sqrt(2.0 * self._deceleration * self.SIGHT))
        wary = max(self._wary(direction), 0.1 * speed)
        seconds = max(self.HORIZON, 0.5 * speed / self._deceleration + 0.2, self.NEAREST / speed)
        points = self._points(speed, seconds)
        if self._swing.round and self._heading is None:
            # No arc of less than half a turn leads backwards.
            points = points[points[:, 0] * direction > -self._body.radius]
        if not len(points):
            return self._free(command, min(speed, wary), now, if_free)
        if self._heading is not None and (out := self._escape_turn(command, points, now)) is not None:
            return out
        limit = min(self._robot.max_turn, self._robot.max_curvature * speed)
        turn = min(max(command.turn, -limit), limit)
        ahead = self._body.arcs(points, speed=direction * speed, turns=np.array([turn]), seconds=seconds)
        if ahead.times[0] >= seconds and ahead.ease[0] >= 1.0:
            return self._free(command, min(speed, wary), now, if_free)
        limit = min(self._robot.max_turn, self._bend * speed)
        sharpest = min(self._robot.max_turn, self.TURN * (self.HORIZON / seconds))
        turns = np.clip(turn + self._fan * sharpest, -limit, limit)
        paths = self._swing.arcs(points, speed=direction * speed, turns=turns, seconds=seconds)
        speeds = np.minimum(speed * paths.ease, np.sqrt(2.0 * self._deceleration * speed * paths.times))
        # A turn rate error of 1 rad/s costs as much as 0.15 times 0.7 m/s of lost speed.
        deviation_cost = 0.15 * (speed / 0.7) * (seconds / self.HORIZON) * np.abs(turns - turn)
        best = int(np.argmax(speeds - deviation_cost - self._turn_cost(turns, turn, speed)))
        if speeds[best] < 0.1 * speed:
            return self._leave(command, points, now)
        self._note_side(float(turns[best]) - turn, now)
        chosen, slow = float(turns[best]), min(float(speeds[best]), wary)
        # A robot that cannot turn on the spot turns less while it is slower.
        limit = self._bend * slow
        return replace(command, forward=direction * slow, turn=min(max(chosen, -limit), limit))

    def _wary(self, direction: float) -> float:
        """Return the speed from which the robot can stop within its part of the free space measured ahead [m/s]."""
        nears = direction * self._cosines
        ahead = nears > self.AHEAD
        room = self.OWN * np.maximum(self._ring[ahead] - MAX_TOUCHING_DISTANCE, 0.0)
        return float(np.min(np.sqrt(2.0 * self._deceleration * room) / nears[ahead]))

    def _free(self, command: Command, speed: float, now: float, if_free: Command | None) -> Command:
        """Return the command for a free path."""
        if now - self._held > self.HOLD or if_free is not None:
            self._forget()
        self._heading = None
        if if_free is not None or speed == abs(command.forward):
            return if_free or command
        return replace(command, forward=math.copysign(speed, command.forward))

    def _turn_cost(self, turns: Array, commanded: float, speed: float) -> Array:
        """Return the cost of turning back and of places visited before, shape (k,) [m/s]."""
        if self._side:
            return np.where((turns - commanded) * self._side < -0.05, 0.4 * speed, 0.0)
        worn = self._trail.worn(self._hits.x, self._hits.y, self._hits.heading + turns)
        return 0.15 * speed * worn

    def _note_side(self, deviation: float, now: float) -> None:
        """Remember the side on which the robot passes the obstacle, and since when."""
        if abs(deviation) < 0.1:
            if now - self._held > self.HOLD:
                self._side = 0.0
            return
        if not self._side:
            self._side, self._met_at = math.copysign(1.0, deviation), now
        self._held = now

    def _leave(self, command: Command, points: Array, now: float) -> Command:
        """Return an escape manoeuvre if there is no free path: turn on the spot, or back off."""
        if now - self._held > self.HOLD:
            self._met_at = now
        self._held = now
        self._heading = self._hits.heading + self._escape_angle(command)
        out = self._escape_turn(command, points, now)
        return replace(command, forward=0.0, turn=0.0) if out is None else out

    def _escape_angle(self, command: Command) -> float:
        """Return the angle to turn to a free direction where the robot has been least [rad]."""
        direction, speed = math.copysign(1.0, command.forward), max(abs(command.forward), 0.1)
        seconds = max(self.HORIZON, 0.8 / speed)
        bearings, points = self._bearings, self._points(speed, seconds)
        paths = self._swing.lines(points, speed=direction * speed, bearings=bearings, seconds=seconds, turned=True)
        forward = self._hits.heading + (0.0 if direction > 0.0 else math.pi)
        worn = self._trail.worn(self._hits.x, self._hits.y, forward + bearings)
        chance = self._rng.uniform(0.0, 0.2, len(bearings))
        cost = worn + chance + 0.1 * np.abs(bearings)
        enough = paths.times >= 0.7 * float(np.max(paths.times))
        return float(bearings[int(np.argmin(np.where(enough, cost, np.inf)))])

    def _escape_turn(self, command: Command, points: Array, now: float) -> Command | None:
        """Return the turn towards the escape, on the spot if there is room, else backward; None when done."""
        assert self._heading is not None
        error = wrap_angle(self._heading - self._hits.heading)
        self._held = now
        if abs(error) < 0.1:
            self._heading, self._stroke = None, 0.0
            return None
        fastest = min(self._robot.max_turn, 1.2, math.sqrt(self._robot.max_turn_acceleration * abs(error)))
        turn = math.copysign(fastest, error)
        if self._spins and self._body.can_spin(points, turn):
            self._stroke = 0.0
            return replace(command, forward=0.0, turn=turn)
        if (arc := self._turn_in_strokes(command, points, error)) is not None:
            return arc
        # No space at either end.
        self._heading, self._side = None, math.copysign(1.0, error)
        if not self._spins or not self._body.can_spin(points, -turn):
            return None
        return replace(command, forward=0.0, turn=-turn)

    def _turn_in_strokes(self, command: Command, points: Array, error: float) -> Command | None:
        """Return an arc backward, then forward, that turns the front to the escape; None without room."""
        for stroke in (1.0,) if self._stroke > 0.0 else (-1.0, 1.0):
            if self._stroke != stroke:
                # It must first stop, then accelerate again.
                changing = abs(command.forward) / self._robot.max_acceleration
                self._stroke, self._left = stroke, round((self.STROKE + changing) / self._robot.dt)
            self._left -= 1
            direction = stroke * math.copysign(1.0, command.forward)
            arc = self._squeeze(command, points, error, share=0.6, direction=direction) if self._left > 0 else None
            if arc is not None:
                # Steering while it still rolls in the other direction would swing its front back.
                return replace(arc, turn=0.0) if self._pace * direction < -self.ROLLS else arc
        self._stroke = 0.0
        return None

    def _squeeze(
        self, command: Command, points: Array, side: float, *, share: float, direction: float
    ) -> Command | None:
        """Return the arc with the largest clearance that turns to a side; None if there is none.

        Args:
            command: Gives the speed.
            points: Obstacles, robot's frame, shape (n, 2) [m].
            side: Its sign gives the side to turn to.
            share: Factor of the speed.
            direction: 1 forward, -1 backward.
        """
        speed = share * abs(command.forward)
        limit = min(self._robot.max_turn, self._bend * speed)
        turns = math.copysign(limit, side) * np.array([1.0, 0.5, 0.2, 0.05, 0.0, -0.05, -0.2, -0.5, -1.0])
        paths = self._body.arcs(points, speed=direction * speed, turns=turns, seconds=self.HORIZON)
        free = paths.times * speed
        best = int(np.argmax(np.minimum(free, 0.6 * speed * self.HORIZON) - 1e-3 * np.arange(9)))
        slow = min(speed, math.sqrt(2.0 * self._deceleration * float(free[best])))
        if slow < 0.1 * speed:
            return None
        return replace(command, forward=direction * slow, turn=float(turns[best]) * slow / speed)

    def _sidestep(self, command: Command) -> Command:
        """Return the free direction closest to the commanded one, for omnidirectional robots; stop if there is none."""
        speed = math.hypot(command.forward, command.left)
        seconds = max(self.HORIZON, 0.5 * speed / self._deceleration + 0.2)
        points = self._points(speed, seconds)
        if not len(points):
            return command
        offsets = np.linspace(-1.0, 1.0, 25) * 0.45 * math.pi
        bearings = math.atan2(command.left, command.forward) + offsets
        paths = self._body.lines(points, speed=speed, bearings=bearings, seconds=seconds, turned=False)
        speeds = np.minimum(speed, np.sqrt(2.0 * self._deceleration * speed * paths.times)) * paths.ease
        best = int(np.argmax(speeds * (1.0 - 0.3 * np.abs(offsets))))
        ahead, left = math.cos(float(bearings[best])), math.sin(float(bearings[best]))
        turn = command.turn if not command.turn or self._body.can_spin(points, command.turn) else 0.0
        return replace(command, forward=float(speeds[best]) * ahead, left=float(speeds[best]) * left, turn=turn)


def _mounting(robot: RobotInfo, lidar: str) -> Array:
    """Return robot_from_lidar, shape (4, 4) [m]; raises ValueError if the robot has no lidar of that name."""
    lidars = [name for name, sensor in robot.sensors.items() if sensor.kind == "lidar"]
    if lidar not in lidars:
        raise ValueError(
            Sentence(
                "no lidar '{lidar}' on '{name}'; there are {value}", lidar, robot.name, ", ".join(lidars) or "none"
            )
        )
    return robot.sensors[lidar].robot_from_sensor


class Trail:
    """Places where the robot has been, some decimetres apart, in the frame of odometry."""

    CAPACITY = 512
    STEP = 0.3
    """Distance between two places [m]."""
    SIGHT = 4.0
    """Places farther than this are ignored [m]."""
    WIDTH = 0.4
    """Half width of a sector in which places are counted [rad]."""

    def __init__(self) -> None:
        """Start with no remembered places."""
        self._places = np.full((self.CAPACITY, 2), np.inf)
        self._count = 0
        self._last = (math.inf, math.inf)

    def add(self, x: float, y: float) -> None:
        """Store the position of the robot [m], if it is far enough from the last one."""
        if math.dist((x, y), self._last) >= self.STEP:
            self._last = (x, y)
            self._places[self._count % self.CAPACITY] = x, y
            self._count += 1

    def worn(self, x: float, y: float, headings: Array) -> Array:
        """Return how often the robot was in each direction from a place, weighted by proximity, (k,), in [0, 1].

        Args:
            x: x of the place, frame of odometry [m].
            y: y of the place [m].
            headings: Directions, frame of odometry, shape (k,) [rad].
        """
        places = self._places[: self._count]
        dx, dy = places[:, 0] - x, places[:, 1] - y
        distance = np.hypot(dx, dy)
        ahead = (np.cos(headings)[:, None] * dx + np.sin(headings)[:, None] * dy) / np.maximum(distance, 1e-9)
        weight = np.where((distance > self.STEP) & (distance < self.SIGHT), 1.0 / np.maximum(distance, self.STEP), 0.0)
        often = np.asarray((ahead > math.cos(self.WIDTH)) @ weight, dtype=float)
        return often / max(float(np.max(often)), 1.0)
