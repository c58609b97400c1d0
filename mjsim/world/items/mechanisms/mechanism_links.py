"""Bodies of mechanisms: rods, boxes, cylinders, balls and models, with their masses."""

import math
from abc import abstractmethod
from typing import TYPE_CHECKING, Annotated, Self

from pydantic import Field, model_validator

from mjsim.sentences import Sentence
from mjsim.world.ground import Color, Length, Model, OneOf, Point3, RollPitchYaw, fault
from mjsim.world.items.mechanisms.points import GROUND, PartName
from mjsim.world.items.model_files import FromFile

if TYPE_CHECKING:  # Imported where it is used: worlds without mechanisms load faster.
    from mjsim.geometry import Array
    from mjsim.mechanics import Solid

DENSITY = 1000.0
"""Density of a body without a given mass [kg/m^3]."""

LIGHTEST = 1e-9
"""Smallest mass of a moving body in the physics [kg]."""
RIM = 24
"""Number of points on the rim of a cylinder."""


class _Body(Model):
    name: PartName
    """Name; in the scene, `MECHANISM/BODY`."""
    at: Point3 = (0.0, 0.0, 0.0)
    """Position of its shape in its frame [m]."""
    rpy_deg: RollPitchYaw = (0.0, 0.0, 0.0)
    """[roll, pitch, yaw] of its shape in its frame, right-handed, in this order."""
    mass: Annotated[float, Field(gt=0, le=1e6)] | None = None
    """Mass; default: that of its shape at 1000 kg/m^3, or of its file [kg]."""
    center: Point3 | None = None
    """Centre of mass in its frame [m]; default: that of its shape."""
    inertia: (
        Annotated[tuple[Annotated[float, Field(ge=-1e9, le=1e9)], ...], Field(strict=False, min_length=6, max_length=6)]
        | None
    ) = None
    """[ixx, iyy, izz, ixy, iyz, ixz] about its centre of mass, along the axes of its frame [kg m^2]; default: that of
    its shape."""
    color: Color = "#7d93ab"
    """'#rrggbb'."""
    friction: Annotated[float, Field(ge=0, le=10)] = 0.8
    """Coefficient of friction."""

    @model_validator(mode="after")
    def _can_be(self) -> Self:
        if self.name == GROUND:
            raise fault(Sentence("'{ground}' is the fixed frame; give the body another name", GROUND), "name")
        if self.mass is not None and self.mass < LIGHTEST:
            raise fault(
                Sentence("the mass is {mass:g} kg; make it at least {lightest:g} kg", self.mass, LIGHTEST), "mass"
            )
        if self.inertia is not None:
            _check_inertia(self.inertia)
        return self

    @abstractmethod
    def own_mass(self) -> float:
        """Return the mass of its shape [kg]."""

    def middle(self) -> tuple[float, float, float]:
        """Return the centre of mass of its shape, frame of the shape [m]."""
        return (0.0, 0.0, 0.0)

    @abstractmethod
    def own_tensor(self) -> "Array":
        """Return the inertia of its shape about its centre of mass for 1 kg, axes of the shape, shape (3, 3) [m^2]."""

    @abstractmethod
    def ends(self) -> dict[str, tuple[float, float, float]]:
        """Return its named points, frame of the shape [m]."""

    @abstractmethod
    def spans(self) -> tuple[list[tuple[float, float, float]], float]:
        """Return points and a radius [m]: its shape is the convex hull of balls at the points, frame of the shape."""

    def hull(self) -> "tuple[Array, float]":
        """Return the points of `spans` in the frame of the body, shape (n, 3) [m], and the radius of the balls [m]."""
        import numpy as np

        points, radius = self.spans()
        frame = self.frame()
        return np.array(points) @ frame[:3, :3].T + frame[:3, 3], radius

    def frame(self) -> "Array":
        """Return body_from_shape, shape (4, 4) [m]."""
        from mjsim.mechanics import placed

        return placed(self.at, [math.radians(angle) for angle in self.rpy_deg])

    def points(self) -> dict[str, tuple[float, ...]]:
        """Return its named points in its own frame [m]."""
        frame = self.frame()
        found = {name: tuple((frame[:3, :3] @ at + frame[:3, 3]).tolist()) for name, at in self.ends().items()}
        return {**found, "center": self.solid().center}

    def solid(self) -> "Solid":
        """Return its mass, its centre of mass and its inertia."""
        import numpy as np

        from mjsim.mechanics import Solid

        frame, mass = self.frame(), self.own_mass() if self.mass is None else self.mass
        center = frame[:3, :3] @ self.middle() + frame[:3, 3] if self.center is None else np.array(self.center)
        tensor = mass * frame[:3, :3] @ self.own_tensor() @ frame[:3, :3].T
        own = [tensor[0, 0], tensor[1, 1], tensor[2, 2], tensor[0, 1], tensor[1, 2], tensor[0, 2]]
        xx, yy, zz, xy, yz, xz = map(float, own if self.inertia is None else self.inertia)
        return Solid(
            mass=mass,
            center=tuple(center.tolist()),
            inertia=(xx, yy, zz, xy, yz, xz),
        )


def _check_inertia(inertia: tuple[float, ...]) -> None:
    import numpy as np

    xx, yy, zz, xy, yz, xz = inertia
    smallest, middle, largest = np.linalg.eigvalsh(np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])).tolist()
    if smallest < -1e-9 * max(largest, 1e-300):
        raise fault(
            Sentence("the inertia has a principal moment of {smallest:g} kg m^2; it must not be below 0", smallest),
            "inertia",
        )
    if smallest + middle < largest * (1.0 - 1e-9):
        raise fault(
            Sentence(
                "the principal moments of inertia are {smallest:g}, {middle:g} and {largest:g} kg m^2; the"
                " largest must not exceed the sum of the others",
                *(smallest, middle, largest),
            ),
            "inertia",
        )


class _Even(_Body):
    """A body of uniform density."""

    @abstractmethod
    def volume(self) -> float:
        """Return the volume of its shape [m^3]."""

    @abstractmethod
    def squares(self) -> tuple[float, float, float]:
        """Return the moments of inertia of its shape about its centre, for a mass of 1 kg [m^2]."""

    def own_mass(self) -> float:
        """Return the mass of its shape at 1000 kg/m^3 [kg]."""
        return DENSITY * self.volume()

    def own_tensor(self) -> "Array":
        """Return the inertia of its shape for a mass of 1 kg, shape (3, 3) [m^2]."""
        import numpy as np

        return np.diag(self.squares())


class MechanismRod(_Even):
    """A rod along +x of its frame, starting at the origin."""

    rod: Annotated[tuple[Length, ...], Field(strict=False, min_length=2, max_length=2)]
    """[length, radius] [m]."""

    def volume(self) -> float:
        """Return the volume of a cylinder [m^3]."""
        return math.pi * self.rod[1] ** 2 * self.rod[0]

    def middle(self) -> tuple[float, float, float]:
        """Return its centre [m]."""
        return (self.rod[0] / 2, 0.0, 0.0)

    def squares(self) -> tuple[float, float, float]:
        """Return the moments of a cylinder [m^2]."""
        length, radius = self.rod
        across = length**2 / 12 + radius**2 / 4
        return (radius**2 / 2, across, across)

    def ends(self) -> dict[str, tuple[float, float, float]]:
        """Return its far end [m]."""
        return {"end": (self.rod[0], 0.0, 0.0)}

    def spans(self) -> tuple[list[tuple[float, float, float]], float]:
        """Return its ends and its radius [m]."""
        return [(0.0, 0.0, 0.0), (self.rod[0], 0.0, 0.0)], self.rod[1]


class MechanismBox(_Even):
    """A box centred on the origin of its frame."""

    box: Annotated[tuple[Length, ...], Field(strict=False, min_length=3, max_length=3)]
    """Full size along x, y and z [m]."""

    def volume(self) -> float:
        """Return length times width times height [m^3]."""
        return math.prod(self.box)

    def squares(self) -> tuple[float, float, float]:
        """Return the moments of a box [m^2]."""
        x, y, z = (size**2 / 12 for size in self.box)
        return (y + z, x + z, x + y)

    def ends(self) -> dict[str, tuple[float, float, float]]:
        """Return the centres of four faces [m]."""
        x, _, z = (size / 2 for size in self.box)
        return {"end": (x, 0.0, 0.0), "start": (-x, 0.0, 0.0), "top": (0.0, 0.0, z), "bottom": (0.0, 0.0, -z)}

    def spans(self) -> tuple[list[tuple[float, float, float]], float]:
        """Return its corners [m]."""
        x, y, z = (size / 2 for size in self.box)
        return [(a, b, c) for a in (-x, x) for b in (-y, y) for c in (-z, z)], 0.0


class MechanismCylinder(_Even):
    """A cylinder centred on the origin of its frame, along z."""

    cylinder: Annotated[tuple[Length, ...], Field(strict=False, min_length=2, max_length=2)]
    """[radius, height] [m]."""

    def volume(self) -> float:
        """Return base times height [m^3]."""
        return math.pi * self.cylinder[0] ** 2 * self.cylinder[1]

    def squares(self) -> tuple[float, float, float]:
        """Return the moments of a cylinder [m^2]."""
        radius, height = self.cylinder
        across = height**2 / 12 + radius**2 / 4
        return (across, across, radius**2 / 2)

    def ends(self) -> dict[str, tuple[float, float, float]]:
        """Return the centres of its faces [m]."""
        return {"top": (0.0, 0.0, self.cylinder[1] / 2), "bottom": (0.0, 0.0, -self.cylinder[1] / 2)}

    def spans(self) -> tuple[list[tuple[float, float, float]], float]:
        """Return points of both rims [m]."""
        radius, height = self.cylinder
        turns = [2.0 * math.pi * number / RIM for number in range(RIM)]
        ring = [(radius * math.cos(turn), radius * math.sin(turn)) for turn in turns]
        return [(x, y, z) for x, y in ring for z in (-height / 2, height / 2)], 0.0


class MechanismBall(_Even):
    """A sphere centred on the origin of its frame."""

    sphere: Length
    """Its radius [m]."""

    def volume(self) -> float:
        """Return the volume of a ball [m^3]."""
        return 4.0 / 3.0 * math.pi * self.sphere**3

    def squares(self) -> tuple[float, float, float]:
        """Return the moments of a ball [m^2]."""
        return (0.4 * self.sphere**2,) * 3

    def ends(self) -> dict[str, tuple[float, float, float]]:
        """Return an empty mapping: all bodies have a centre."""
        return {}

    def spans(self) -> tuple[list[tuple[float, float, float]], float]:
        """Return its centre and its radius [m]."""
        return [(0.0, 0.0, 0.0)], self.sphere


class MechanismModel(FromFile, _Body):
    """A body from a file, with the frame of the file; joints of the file are fixed."""

    @model_validator(mode="after")
    def _weighs(self) -> Self:
        has_inertia = None not in (self.mass, self.center, self.inertia)
        # The file is known to exist only if it was read with its world.
        if not has_inertia and "shape" in vars(self) and self.shape.whole.mass <= 0.0:
            raise fault(Sentence("'{model}' has no mass; give mass, center and inertia", self.model), "model")
        return self

    def own_mass(self) -> float:
        """Return the mass of the file, which is proportional to the cube of `scale` [kg]."""
        return self.shape.whole.mass * self.scale**3

    def middle(self) -> tuple[float, float, float]:
        """Return the centre of mass of the file [m]."""
        x, y, z = (self.shape.whole.center * self.scale).tolist()
        return (x, y, z)

    def own_tensor(self) -> "Array":
        """Return the inertia of the file, shape (3, 3) [m^2]; zeros where it has no mass."""
        whole = self.shape.whole
        return whole.inertia * (self.scale**2 / whole.mass) if whole.mass > 0.0 else whole.inertia

    def ends(self) -> dict[str, tuple[float, float, float]]:
        """Return an empty mapping: all bodies have a centre; other points are written as {BODY: [x, y, z]}."""
        return {}

    def spans(self) -> tuple[list[tuple[float, float, float]], float]:
        """Return corners of the convex hull of all collision shapes [m]."""
        return [(x, y, z) for x, y, z in (self.shape.whole.corners * self.scale).tolist()], 0.0


BODIES: dict[str, type[_Body]] = {
    "rod": MechanismRod,
    "box": MechanismBox,
    "cylinder": MechanismCylinder,
    "sphere": MechanismBall,
    "model": MechanismModel,
}
"""Bodies by the key of their shape."""

MechanismBody = Annotated[
    MechanismRod | MechanismBox | MechanismCylinder | MechanismBall | MechanismModel,
    OneOf(
        BODIES,
        "a body needs its shape; write rod: [length, radius], box: [length, width, height], cylinder: [radius, height],"
        " sphere: radius, or model: FILE",
    ),
]
