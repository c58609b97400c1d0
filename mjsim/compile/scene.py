"""World -> MjSpec: the room, its light, the views from outside, and the robots."""

import math

import mujoco
import numpy as np

from mjsim.compile.collision_filters import sort_contacts
from mjsim.compile.obstacles import add_obstacles
from mjsim.compile.overview import OVERVIEW_FOV, overview_place, scene_bounds
from mjsim.compile.physics import set_physics
from mjsim.compile.robots import add_robots
from mjsim.compile.room import (
    Decor,
    add_carried_beacons,
    add_ceiling,
    add_doors,
    add_floor,
    add_hung_beacons,
    add_patches,
    add_walls,
    ceiling_height,
    face_maker,
    merge_furniture,
    wall_boxes,
)
from mjsim.compile.scene_lamps import add_general_light, add_lamps, divide_faces, light_pictures
from mjsim.compile.textures import add_matte
from mjsim.geometry import Array
from mjsim.models import quaternion_of
from mjsim.world import Camera, Robot, World, gc_paused

NEAR_CLIPPING = 0.02
"""Near clipping distance of cameras, independent of the size of the world [m]."""
MIN_BUFFER_WIDTH, MIN_BUFFER_HEIGHT = 1920, 1080
"""Minimum size of the offscreen buffer [px]."""
CHASE_AT, CHASE_TILT, CHASE_FOV = (-1.6, 0.0, 2.7), math.radians(46.0), 55.0
"""Position in the robot's frame [m], above most walls so that none hides the robot; downward tilt [rad]; vertical field
of view [deg]."""


@gc_paused()
def compile_world(world: World) -> mujoco.MjSpec:
    """Return the scene of a world, its pictures in memory: as pixels of textures, which `export_scene` writes as files.

    Geoms of group 0 are visible and collide, of group 1 are visible only, of group 3 collide only, of group 4 are shown
    by a merged mesh. Cameras see groups 0 and 1, range sensors 0 and 3.

    Raises:
        UsageError: The world exceeds a limit of MuJoCo.
        WorldError: The file of a model cannot be read.
        ValueError: A picture cannot be read.
    """
    spec = mujoco.MjSpec()
    spec.modelname = world.name
    boxes = wall_boxes(world.walls)
    lower, upper = scene_bounds(world, boxes)
    set_physics(spec, world.run.step)
    _set_visual(spec, world, lower, upper)
    add_general_light(spec, world.light, lower, upper)
    add_lamps(spec, world)
    add_matte(spec, "matte")
    # Cameras draw geoms in this order; likely foreground comes first, so that less is painted over.
    face_of = face_maker(spec, world)
    add_hung_beacons(spec, world, boxes, face_of)
    add_obstacles(spec, world)
    decor = None if world.style == "plain" else Decor(spec, world, world.style)
    if decor is not None:
        decor.add_to_things()
    merge_furniture(spec, world)
    add_doors(spec, world)
    if decor is not None:
        ceiling = world.ceiling
        decor.add_to_rooms(None if ceiling is None else ceiling_height(ceiling, boxes, float(upper[2])))
    add_walls(spec, world, boxes)
    add_ceiling(spec, world, boxes, lower, upper)
    add_patches(spec, world)
    add_floor(spec, world, lower, upper)
    _add_overview(spec, lower, upper)
    if world.mechanisms:
        from mjsim.compile.mechanism_specs import add_mechanisms

        add_mechanisms(spec, world)
    if world.people:
        from mjsim.compile.person_bodies import add_people

        add_people(spec, world)
    add_robots(spec, world)
    for robot in world.robots:
        _add_chase(spec, robot)
    add_carried_beacons(spec, world, face_of)
    sort_contacts(spec)
    light_pictures(spec, world)
    if world.lamps:
        divide_faces(spec)
    return spec


SHADOWED = 1.7
"""Half side of the shadow map, relative to the extent. Beyond it the floor is speckled, which no view may show."""


def _set_visual(spec: mujoco.MjSpec, world: World, lower: Array, upper: Array) -> None:
    """Set sizes, clipping planes and image quality: flat faces need no subdivision for even light."""
    diagonal = float(np.linalg.norm(upper - lower))
    spec.stat.center = (lower + upper) / 2
    spec.stat.extent = diagonal / 2
    spec.visual.map.znear = NEAR_CLIPPING / spec.stat.extent
    spec.visual.map.zfar = (4.0 * diagonal + 50.0) / spec.stat.extent
    spec.visual.map.shadowclip = SHADOWED
    cameras = [sensor for robot in world.robots for sensor in robot.sensors if isinstance(sensor, Camera)]
    spec.visual.global_.offwidth = max([MIN_BUFFER_WIDTH, *(camera.width for camera in cameras)])
    spec.visual.global_.offheight = max([MIN_BUFFER_HEIGHT, *(camera.height for camera in cameras)])
    spec.visual.quality.shadowsize = 0
    spec.visual.quality.offsamples = 0
    spec.visual.quality.numquads = 1


def _add_overview(spec: mujoco.MjSpec, lower: Array, upper: Array) -> None:
    """Add a camera from above at an angle that sees every corner of the world."""
    place, right, up = overview_place(lower, upper)
    spec.worldbody.add_camera(name="overview", pos=place, quat=_camera_quaternion(right, up), fovy=OVERVIEW_FOV)


def _add_chase(spec: mujoco.MjSpec, robot: Robot) -> None:
    """Add a chase camera behind and above a robot, unless the robot has a camera of that name."""
    name = f"{robot.name}/chase"
    if spec.camera(name) is None:
        up = np.array([math.sin(CHASE_TILT), 0.0, math.cos(CHASE_TILT)])
        spec.body(f"{robot.name}/base").add_camera(
            name=name, pos=CHASE_AT, quat=_camera_quaternion(np.array([0.0, -1.0, 0.0]), up), fovy=CHASE_FOV
        )


def _camera_quaternion(right: Array, up: Array) -> Array:
    """Return the orientation of a camera of MuJoCo: x to the right, y up, looking against z."""
    return quaternion_of(np.column_stack([right, up, np.cross(right, up)]))
