"""Model predictive path integral control: samples motions, and averages them by their cost."""

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from mjsim.geometry import Array, Pose
from mjsim.interface import RobotInfo

from .body_discs import BodyDiscs
from .cost_to_go import allowed_speed
from .moving_things import Thing
from .obstacle_map import ObstacleMap

STEPS, STEP = 20, 0.08
"""Number and duration of the steps of a sampled motion [s]."""
KNOTS = 5
"""Number of independent random changes in a motion; between them they are interpolated."""
SAMPLES = 200
"""Number of motions that are sampled each time."""
TEMPERATURE = 0.05
"""Difference in cost at which a motion counts e times less [s]."""
MARGIN = 0.02
"""Distance that the body keeps from obstacles [m]."""
CLOSER = 0.004
"""Distance by which it may approach obstacles within the margin: errors of the grid [m]."""
LONG_MARGIN, LONG_TIGHT = 0.03, 0.012
"""The same for a long body, whose ends are swept by errors of the heading, too, and what it keeps where it is tight
[m]."""
HIT = 50.0
"""Cost of a collision [s]."""
LAST = 0.6
"""Weight of the end of a motion in its cost; the rest is that of the motion itself."""
TOO_FAST = 2.0
"""Cost of a speed above the allowed one [s/m]."""
CLOSE, COMFORT = 0.5, 0.12
"""Cost of time spent at no clearance, falling to 0 at a comfortable one [1, m]."""
MET, SPACE, UNSURE = 15.0, 0.25, 0.12
"""Cost of time at no distance from things that move, falling to 0 at a space [1, m], which grows with time [m/s]."""
MEETING, REACTION, CREEPING = 5.0, 0.3, 0.05
"""Cost of driving into moving things, time until the robot begins to stop, and speed at which it counts as standing [s,
s, m/s]."""
CHANGE = 0.01
"""Cost of a change of the twist by the robot's limits [s]."""
STEER = math.radians(75.0)
"""Maximum steering angle of a tricycle's wheel used in plans [rad]."""
RESERVE = 0.85
"""Share of the robot's acceleration used in plans."""
FEW, FINEST = 0.25, 0.1
"""If fewer than this share of motions are free, the next ones vary less, down to this share of the robot's limits."""


@dataclass(frozen=True, slots=True)
class MotionPrices:
    """Criteria by which a motion is judged."""

    reverse: float = 1.0
    """Cost of driving backwards [s/m]."""
    top: float = math.inf
    """Speed limit [m/s]."""
    things: tuple[Thing, ...] = ()
    """Moving things, at their current positions."""


class Leads(Protocol):
    """Goals of a motion: the time to a goal, and the direction to face."""

    def at(self, points: Array) -> Array:
        """Return the times from points (..., 2) [s]."""

    def direction(self, points: Array) -> tuple[Array, Array]:
        """Return the direction at points (..., 2): components along x and y, unnormalised."""


class PathIntegral:
    """Chooses the next twist of a robot by sampled motions.

    Motions are random changes of the last one, and a fan of constant twists. Each is simulated with the robot's limits
    of speed, turn rate, curvature and acceleration; its cost is the time to the goal from its end, plus costs of
    nearness to obstacles, of speed beside them and of sharp changes. The mean of all, weighted by exp(-cost), is the
    next motion if it is free, else the best.

    References:
        Williams, Drews, Goldfain, Rehg, Theodorou, Information-Theoretic Model Predictive Control: Theory and
        Applications to Autonomous Driving, IEEE T-RO 34(6), 2018, algorithm 2.
    """

    def __init__(self, robot: RobotInfo, rng: Generator, *, top: float) -> None:
        """Store the limits of the robot.

        Args:
            robot: Data sheet.
            rng: Source of the samples.
            top: Maximum speed [m/s].
        """
        self._rng, self.body = rng, BodyDiscs(robot)
        self._top = min(top, robot.max_speed)
        self._limits: Array = np.array([self._top, min(robot.max_left, self._top), robot.max_turn], dtype=np.float32)
        self.bend, self._is_tricycle = _bend(robot), robot.drive == "tricycle"
        gain = RESERVE * STEP
        most = [robot.max_acceleration, robot.max_acceleration, robot.max_turn_acceleration]
        self._gains = np.array(most, dtype=np.float32) * np.float32(gain)
        self._most_turn, self._turn_gain = robot.max_turn, robot.max_turn_acceleration
        self._spread = (self._limits * (0.35, 0.35, 0.4)).astype(np.float32)
        self._plan = np.zeros((STEPS, 3), dtype=np.float32)
        self._fan = _fan(self._limits, self.bend)
        self._scale = 1.0
        self.motion: Array = np.zeros((0, 3))
        """Poses of the chosen motion, shape (STEPS, 3)."""
        self.clearance = 0.0
        """Clearance of the chosen motion at its narrowest place [m]."""
        self._sampled: tuple[Pose, Array] = (robot.prior, np.zeros((0, STEPS, 3)))

    @property
    def reach(self) -> float:
        """Distance within which obstacles matter [m]."""
        return self._top * STEP * STEPS + self.body.reach + 0.3

    def shift(self, dt: float) -> None:
        """Advance the plan by a time [s]."""
        at = np.minimum(np.arange(STEPS) + dt / STEP, STEPS - 1)
        low = at.astype(int)
        share = (at - low)[:, None].astype(np.float32)
        self._plan = self._plan[low] * (1.0 - share) + self._plan[np.minimum(low + 1, STEPS - 1)] * share

    @property
    def planned(self) -> Array:
        """The twist that the plan begins with, shape (3,) [m/s, m/s, rad/s]."""
        return np.asarray(self._plan[0])

    def reset(self) -> None:
        """Forget the plan."""
        self._plan = np.zeros((STEPS, 3), dtype=np.float32)

    def twist(self, pose: Pose, speed: Array, map: ObstacleMap, field: Leads, prices: MotionPrices) -> Array | None:
        """Return the next twist, shape (3,) [m/s, m/s, rad/s]; None if every motion collides.

        Args:
            pose: Pose of the robot.
            speed: Its current twist, shape (3,).
            map: Obstacles.
            field: Times to the goal.
            prices: The other criteria for a motion.
        """
        wanted = self._samples()
        twists = self._limited(wanted, speed, prices.top)
        self._sampled = pose, twists
        cost, hits = self._judged(pose, twists, map, field, prices)
        # Between posts nearly all motions of full size collide.
        scale = 0.5 if np.count_nonzero(~hits) < FEW * len(hits) else 2.0
        self._scale = min(max(scale * self._scale, FINEST), 1.0)
        if hits.all():
            self.reset()
            return None
        weights = np.exp(-(cost - cost.min()) / TEMPERATURE)
        mean = np.tensordot(weights / weights.sum(), twists, axes=1)
        best = twists[int(np.argmin(cost))]
        # The mean of motions around both sides of an obstacle leads into it.
        both = np.stack([mean, best])
        cost, hits = self._judged(pose, both, map, field, prices)
        chosen = 0 if not hits[0] and cost[0] < cost[1] + TEMPERATURE else 1
        self._plan = both[chosen]
        way = _rollout(pose, both[chosen][None])
        self.motion = np.stack(way, axis=-1)[0]
        self.clearance = float(self.body.clearance(*way, map).min())
        return self.planned

    def candidates(self, most: int) -> Array:
        """Return places on some of the motions that were sampled last, at most a number, shape (k, n, 2) [m]."""
        pose, twists = self._sampled
        x, y, _ = _rollout(pose, twists[:: 1 + len(twists) // most])
        return np.stack([x[:, ::3], y[:, ::3]], axis=-1)

    def apart(self, points: Array) -> float:
        """Return the distance between points (n, 2) and the circle about the body on the chosen motion [m]."""
        x, y = self.motion[::2, 0, None] - points[:, 0], self.motion[::2, 1, None] - points[:, 1]
        return math.sqrt(float((x * x + y * y).min(initial=math.inf))) - self.body.reach

    def can_turn(self, pose: Pose, angle: float, map: ObstacleMap) -> bool:
        """Return whether the body can turn on the spot by an angle [rad] without contact."""
        headings = pose.heading + np.linspace(0.0, angle, 2 + int(abs(angle) / 0.05))
        clearance = self.body.clearance(np.full_like(headings, pose.x), np.full_like(headings, pose.y), headings, map)
        return bool(clearance.min() >= min(0.0, float(clearance[0]) - CLOSER))

    def turn(self, pose: Pose, apart: float, map: ObstacleMap) -> float | None:
        """Return the rate of a turn by an angle [rad] on the side where there is room [rad/s]; None without room."""
        free = [way for way in (apart, apart - math.copysign(2.0 * math.pi, apart)) if self.can_turn(pose, way, map)]
        if not free:
            return None
        return math.copysign(min(self._most_turn, math.sqrt(self._turn_gain * abs(free[0]))), free[0])

    def _samples(self) -> Array:
        """Return wanted twists, shape (k, STEPS, 3)."""
        knots = self._rng.standard_normal((SAMPLES, KNOTS, 3), dtype=np.float32) * (self._scale * self._spread)
        at = np.linspace(0.0, KNOTS - 1, STEPS, dtype=np.float32)
        low = np.minimum(at.astype(int), KNOTS - 2)
        share = (at - low)[:, None]
        noise = knots[:, low] * (1.0 - share) + knots[:, low + 1] * share
        noise[0] = 0.0
        fan = self._scale * self._fan
        return np.concatenate([self._plan + noise, np.broadcast_to(fan, (len(fan), STEPS, 3))])

    def _limited(self, wanted: Array, speed: Array, top: float) -> Array:
        """Return twists that the robot can drive, shape (k, STEPS, 3)."""
        limits = self._limits.copy()
        limits[:2] = np.minimum(limits[:2], top)
        wanted = np.minimum(np.maximum(wanted, -limits), limits)
        twists, now = np.empty_like(wanted), np.broadcast_to(speed.astype(np.float32), (len(wanted), 3))
        for step in range(STEPS):
            before, now = now, np.minimum(np.maximum(wanted[:, step], now - self._gains), now + self._gains)
            if self._is_tricycle:
                # With its wheel turned far, it also stops no sooner ahead than it stops to turn.
                rolls = np.maximum(np.abs(before[:, 2]) - self._gains[2], 0.0) / self.bend
                ways = np.copysign(np.float32(1.0), before[:, 0])
                now[:, 0] = ways * np.maximum(ways * now[:, 0], rolls)
            if math.isfinite(self.bend):
                bound = self.bend * np.abs(now[:, 0])
                now[:, 2] = np.minimum(np.maximum(now[:, 2], -bound), bound)
            twists[:, step] = now
        return twists

    def _judged(
        self, pose: Pose, twists: Array, map: ObstacleMap, field: Leads, prices: MotionPrices
    ) -> tuple[Array, NDArray[np.bool_]]:
        """Return the cost of motions, shape (k,) [s], and whether they collide, shape (k,)."""
        x, y, heading = _rollout(pose, twists)
        discs = self.body.clearances(x, y, heading, map)
        now = self.body.clearances(np.array(pose.x), np.array(pose.y), np.array(pose.heading), map)
        # Closer than the margin it may go on, but not approach.
        floors = np.broadcast_to(np.minimum(MARGIN, now.min() - CLOSER), now.shape)
        if self.body.is_long:
            # What one part of a long body is inside of or close to, the others must not touch; it is not approached
            # step by step.
            nearest = max(float(now.min()) - CLOSER, LONG_TIGHT)
            floors = np.minimum(LONG_MARGIN, np.where(now < LONG_TIGHT, now, nearest))
        clearance, hit = discs.min(axis=0), np.any(discs < floors[:, None, None], axis=0)
        hits = np.asarray(hit.any(axis=1))
        when = np.where(hits, hit.argmax(axis=1), STEPS)
        cost = self._led(np.stack([x[:, 3::4], y[:, 3::4]], axis=-1), heading[:, -1], field)
        apart = self._apart(x, y, heading, prices.things)
        # Moving things may turn: beside them the robot drives at half speed.
        cost += self._driven(twists, np.minimum(clearance, 0.5 * apart), prices)
        if prices.things:
            cost += MEETING * self._meets(twists, apart) + STEP * (MET * np.maximum(1.0 - apart / SPACE, 0.0)).sum(
                axis=1
            )
        return np.where(hits, cost + HIT * (2.0 - when / STEPS), cost), hits

    def _meets(self, twists: Array, apart: Array) -> NDArray[np.bool_]:
        """Return which motions drive into moving things within the time that the robot takes to stop, shape (k,).

        References:
            Bouraine, Fraichard, Salhi, Provably Safe Navigation for Mobile Robots with Limited Field-of-Views in
            Dynamic Environments, Autonomous Robots 32(3), 2012: passive safety, to stand before anything is met.
        """
        speed = np.hypot(twists[..., 0], twists[..., 1])
        stops = RESERVE * STEP * float(speed[:, 0].max()) / float(self._gains[0]) + REACTION
        meets = (apart < min(0.0, float(apart[:, 0].max()) - CLOSER)) & (speed > CREEPING)
        meets[:, math.ceil(stops / STEP) :] = False
        return np.asarray(meets.any(axis=1))

    def _apart(self, x: Array, y: Array, heading: Array, things: tuple[Thing, ...]) -> Array:
        """Return the distance between the rim and moving things at poses, shape (k, STEPS) each [m]."""
        least = np.full_like(x, np.inf)
        if not things:
            return least
        times = STEP * np.arange(1, x.shape[1] + 1)
        c, s = np.cos(heading), np.sin(heading)
        for thing in things:
            # Predictions become less certain with time.
            radius = thing.radius + UNSURE * times
            dx, dy = (x - thing.place[0] - times * thing.velocity[0], y - thing.place[1] - times * thing.velocity[1])
            for (ahead, left), own in zip(self.body.centres.tolist(), self.body.radii.tolist(), strict=True):
                away = np.hypot(dx + c * ahead - s * left, dy + s * ahead + c * left)
                np.minimum(least, away - own - radius, out=least)
        return least

    def _led(self, places: Array, heading: Array, field: Leads) -> Array:
        """Return the cost of where motions lead: places (k, n, 2) along them [m], and last headings (k,) [rad]."""
        times = field.at(places)
        ahead, turn = field.direction(places[:, -1])
        course = heading - np.arctan2(turn, ahead)
        cost = LAST * times[:, -1] + (1.0 - LAST) * times.mean(axis=1)
        return np.asarray(cost + self._turning * (1.0 - np.cos(course)) * np.minimum(times[:, -1], 1.0))

    def _driven(self, twists: Array, clearance: Array, prices: MotionPrices) -> Array:
        """Return the cost of how motions are driven: twists (k, STEPS, 3) and clearances (k, STEPS) [m]."""
        speed = np.hypot(twists[..., 0], twists[..., 1])
        price = TOO_FAST * np.maximum(speed - allowed_speed(clearance), 0.0)
        price += CLOSE * np.maximum(1.0 - clearance / COMFORT, 0.0)
        price += prices.reverse * np.maximum(-twists[..., 0], 0.0)
        changes = np.abs(np.diff(twists / np.maximum(self._limits, 1e-6), axis=1)).sum(axis=(1, 2))
        return np.asarray(STEP * price.sum(axis=1) + CHANGE * changes)

    @property
    def _turning(self) -> float:
        """Half the time that a turn by 180 degrees takes [s]."""
        if math.isfinite(self.bend):
            return 2.0 * math.pi / (self.bend * self._top)
        return 0.25 * math.pi / float(self._limits[2])


def _bend(robot: RobotInfo) -> float:
    """Return the maximum curvature used in plans [1/m].

    A tricycle that reverses while its wheel is turned far has to turn it through straight ahead, rolling on.
    """
    if robot.drive != "tricycle":
        return robot.max_curvature
    # With its wheel turned across, it moves as fast about the axle as it would ahead.
    arm = min(robot.max_acceleration / robot.max_turn_acceleration, robot.radius)
    return min(robot.max_curvature, math.tan(STEER) / arm)


def _rollout(pose: Pose, twists: Array) -> tuple[Array, Array, Array]:
    """Return x, y and heading after each step of twists (k, STEPS, 3), shape (k, STEPS) each."""
    turns = STEP * twists[..., 2]
    heading = pose.heading + np.cumsum(turns, axis=1)
    middle = heading - 0.5 * turns
    c, s = np.cos(middle), np.sin(middle)
    forward, left = STEP * twists[..., 0], STEP * twists[..., 1]
    return (
        pose.x + np.cumsum(c * forward - s * left, axis=1),
        pose.y + np.cumsum(s * forward + c * left, axis=1),
        heading,
    )


def _fan(limits: Array, bend: float) -> NDArray[np.float32]:
    """Return constant twists that a robot can always choose from, shape (k, 1, 3)."""
    top, side, turn = limits.tolist()
    rates = np.array([-1.0, -0.6, -0.3, -0.12, 0.0, 0.12, 0.3, 0.6, 1.0])
    twists = [[0.0, 0.0, 0.0]]
    for speed in (1.0, 0.5, 0.2, -0.15, -0.4):
        fastest = min(turn, bend * abs(speed) * top)
        twists += [[speed * top, 0.0, rate * fastest] for rate in rates.tolist()]
    if math.isinf(bend):
        twists += [[0.0, 0.0, rate * turn] for rate in (-0.6, -0.25, 0.25, 0.6)]
    if side > 0.0:
        bearings = np.arange(16) * (math.pi / 8)
        twists += [[top * math.cos(b) * share, side * math.sin(b) * share, 0.0] for b in bearings for share in (0.4, 1)]
    return np.array(twists, dtype=np.float32)[:, None]
