"""Balancing drive: two wheels on one axle, no caster, and a body that falls unless a controller balances it."""

from typing import Annotated, ClassVar, Literal

from pydantic import Field

from mjsim.world.ground import Length, Model
from mjsim.world.items.drives.base import SIDES, Acceleration, AnyDrive, Slip, TorqueMotor, Wheel, half_width
from mjsim.world.items.sensing import Imu, ImuError

OWN_IMU = "drive-imu"
"""Name of the inertial sensor of a balancing base."""
Torque = Annotated[float, Field(gt=0, le=1000)]
"""[N m]"""


class OwnImu(Model):
    """Noise of the built-in inertial sensor of a balancing base, at the axle and read at 250 Hz."""

    noise: ImuError = ImuError()
    """White noise of each reading (standard deviation)."""
    bias: ImuError = ImuError()
    """Standard deviation of the constant bias, drawn once per run."""
    walk: ImuError = ImuError()
    """Random walk of the bias."""


class BalancingDrive(AnyDrive):
    """Only two wheels on one axle; a controller balances the body with the torque of both motors."""

    controller: ClassVar[str | None] = "mjsim.algorithms.balance:Lqr"
    """Linear quadratic regulator, designed from the parameters of the robot."""

    type: Literal["balancing"]
    """Kind of drive."""
    wheel_radius: Length = 0.105
    """[m]"""
    track: Length = 0.43
    """Distance between the wheels [m]."""
    wheel_mass: Annotated[float, Field(gt=0, le=1000)] = 1.0
    """Mass of each wheel, a solid cylinder [kg]."""
    max_torque: Torque = 4.0
    """Maximum torque of the motor of each wheel [N m]."""
    max_acceleration: Acceleration = 0.5
    """Acceleration of the set-points of the controller [m/s^2]."""
    imu: OwnImu = OwnImu()
    """Inertial sensor of the controller, unless `sensors` has one."""

    @property
    def wheels(self) -> tuple[Wheel, ...]:
        """One on each side of the origin."""
        return tuple(
            Wheel(
                name=side,
                at=(0.0, y * self.track / 2),
                radius=self.wheel_radius,
                half_width=half_width(None, radius=self.wheel_radius, track=self.track),
                load="light",
                mass=self.wheel_mass,
                motor=TorqueMotor(self.max_torque),
            )
            for side, y in SIDES
        )

    @property
    def own_imu(self) -> Imu:
        """At the axle."""
        place, errors = (0.0, 0.0, self.wheel_radius), self.imu
        return Imu(imu=OWN_IMU, at=place, rate_hz=250.0, noise=errors.noise, bias=errors.bias, walk=errors.walk)

    @property
    def turning_track(self) -> float:
        """The track [m]."""
        return self.track

    @property
    def slip(self) -> Slip:
        """Slip of two wheels that carry the whole weight."""
        return Slip()
