"""Bodies of mechanisms from MJCF and URDF files: visual and collision shapes."""

from functools import partial

import mujoco
import numpy as np

from mjsim.compile.arm_shapes import solid_keys
from mjsim.compile.geom_groups import MATERIAL
from mjsim.compile.models import LoadedFile, copy_geom, original, try_alone
from mjsim.compile.textures import add_matte
from mjsim.errors import WorldError
from mjsim.geometry import Array
from mjsim.models import pose_keys, seen_and_touched
from mjsim.world import Fault, MechanismModel, World, problems_at


def add_file_shape(
    spec: mujoco.MjSpec, body: mujoco.MjsBody, item: MechanismModel, file: LoadedFile, name: str
) -> None:
    """Add the geoms of a file to a body of a mechanism, its joints at rest.

    Args:
        spec: The scene.
        body: Body in the scene.
        item: Body in the world file.
        file: File of the item in this scene.
        name: `MECHANISM/BODY`, which the first geom gets; the others are NAME-2 and so on.
    """
    frame, data = item.frame(), item.shape.whole.rest.data
    plain = item.color if "color" in item.model_fields_set else None
    seen, touched = seen_and_touched(file.model, urdf=file.urdf)
    for count, number in enumerate(np.flatnonzero(seen | touched).tolist(), start=1):
        keys = solid_keys(file.model, number, seen=bool(seen[number]), touched=bool(touched[number]))
        if "friction" in keys and "friction" in item.model_fields_set:
            keys["friction"] = [item.friction, 0.005, 0.0001]
        keys |= file.looks.of_geom(number, plain=plain) | pose_keys(frame @ _placed(data, number, item.scale))
        keys["name"] = name if count == 1 else f"{name}-{count}"
        copy_geom(spec, body, file, number, scale=item.scale, **keys)


def _placed(data: mujoco.MjData, number: int, scale: float) -> Array:
    """Return shape_from_geom, shape (4, 4) [m]."""
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = data.geom_xmat[number].reshape(3, 3), data.geom_xpos[number] * scale
    return pose


def check_mechanism_files(world: World) -> None:
    """Raise WorldError when MuJoCo cannot read the files of bodies of mechanisms, each as the only thing in a world."""
    faults: list[Fault] = []
    for index, mechanism in enumerate(world.mechanisms):
        for number, item in enumerate(mechanism.bodies):
            if isinstance(item, MechanismModel):
                try:
                    _try_file(item)
                except ValueError as error:
                    faults.append((("mechanisms", index, "bodies", number, "model"), partial(str, error)))
    if faults:
        raise WorldError(problems_at(world.source.written, world.source.file, faults))


def _try_file(item: MechanismModel) -> None:
    """Raise ValueError when the shapes of a file cannot be part of a scene."""
    spec = mujoco.MjSpec()
    add_matte(spec, MATERIAL)
    body = spec.worldbody.add_body(name="body")
    add_file_shape(spec, body, item, original(spec, item.shape, key="model"), name="body")
    try_alone(spec, item.model)
