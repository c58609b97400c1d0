"""Commands from signals over time: to identify a robot, or to drive it in open loop."""

from collections.abc import Mapping, Sequence
from typing import Any

from numpy.random import Generator, default_rng

from mjsim import ArmInfo, Command, Estimate, JointGoal, Observation, RobotInfo, WorldMap, signal_of
from mjsim.mechanics import TimeSignal

Keys = Mapping[str, Any]
"""A signal from the world file, such as {"step": {"to": 0.5, "at": 1}}."""


class Signal:
    """Commands a twist, and goals of the arms, from signals; time starts at the first tick.

    The bump reaction, and avoidance if enabled, still apply. Without a signal a speed is 0.
    """

    def __init__(
        self,
        *,
        forward: Keys | None = None,
        left: Keys | None = None,
        turn: Keys | None = None,
        joints: Mapping[str, Sequence[Keys]] | None = None,
    ) -> None:
        """Set the signals.

        Args:
            forward: Forward velocity in the robot's frame [m/s].
            left: Likewise, to the left [m/s].
            turn: Counter-clockwise positive; its keys end in `_deg` [deg/s].
            joints: For each arm by name, one signal per joint: with keys ending in `_deg` for revolute joints [deg], in
                metres for prismatic ones.

        Raises:
            ValueError: There is no signal, or one is invalid.
        """
        if forward is None and left is None and turn is None and not joints:
            raise ValueError("no signal is given; give forward, left, turn or joints, such as forward: {sine: {...}}")
        self._keys = {"forward": forward, "left": left, "turn": turn}
        self._joints = joints or {}
        for name, keys in self._keys.items():
            if keys is not None:
                _made(name, keys, angle=name == "turn", rng=None)

    def start(self, robot: RobotInfo, map: WorldMap | None, rng: Generator) -> None:
        """Create the signals; random ones use the module's own random stream.

        Raises:
            ValueError: The robot has no such arm, or the arm has fewer joints.
        """
        # Each has a source of its own, whichever others there are.
        given = [(name, keys, _source(rng)) for name, keys in self._keys.items()]
        self._twist = {
            name: _made(name, keys, angle=name == "turn", rng=source)
            for name, keys, source in given
            if keys is not None
        }
        self._arms = {}
        for name, each in self._joints.items():
            slides = _slides(robot, name, len(each))
            self._arms[name] = [
                _made(f"joints.{name}[{k}]", keys, angle=not slides[k], rng=_source(rng)) for k, keys in enumerate(each)
            ]
        self._began: float | None = None

    def command(self, seen: Observation, belief: Estimate) -> Command:
        """Return the twist and the goals of this tick."""
        if self._began is None:
            self._began = seen.time
        time = seen.time - self._began
        forward, left, turn = (self._speed(name, time) for name in ("forward", "left", "turn"))
        joints = {name: _goal(signals, time) for name, signals in self._arms.items()}
        return Command(forward, left, turn, joints=joints)

    def _speed(self, name: str, time: float) -> float:
        return float(self._twist[name].value(time)) if name in self._twist else 0.0


def _made(name: str, keys: Keys, *, angle: bool, rng: Generator | None) -> TimeSignal:
    try:
        return signal_of(keys, angle=angle, rng=rng)
    except ValueError as error:
        raise ValueError(f"{name}: {error}") from None


def _source(rng: Generator) -> Generator:
    return default_rng(int(rng.integers(2**63)))


def _slides(robot: RobotInfo, arm: str, count: int) -> list[bool]:
    """Return for each joint of an arm whether it slides."""
    info: ArmInfo | None = robot.arms.get(arm)
    if info is None:
        raise ValueError(f"robot '{robot.name}' has no arm '{arm}'; its arms are {', '.join(robot.arms) or 'none'}")
    if len(info.joints) != count:
        raise ValueError(f"joints.{arm} holds {count} signals; the arm has {len(info.joints)} joints")
    return [link.slide for link in info.model.links]


def _goal(signals: Sequence[TimeSignal], time: float) -> JointGoal:
    return JointGoal(
        positions=tuple(float(signal.value(time)) for signal in signals),
        velocities=tuple(float(signal.rate(time)) for signal in signals),
        accelerations=tuple(float(signal.second(time)) for signal in signals),
    )
