"""The true motion of the joints of an arm or a mechanism at one time."""

from dataclasses import dataclass

from mjsim.geometry import Array


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class JointMotion:
    """The true motion of joints; each array has shape (joints,), in rad and N m, or m and N for prismatic joints."""

    names: tuple[str, ...]
    positions: Array
    velocities: Array
    """[rad/s, m/s]"""
    accelerations: Array
    """Accelerations in the last step of the physics [rad/s^2, m/s^2]."""
    torques: Array
    """Torques of the motors, at the joints [N m, N]."""
    goal: Array
    """Set-points of the joints."""
    tool: Array | None = None
    """world_from_tool of an arm, shape (4, 4) [m]; None otherwise."""
