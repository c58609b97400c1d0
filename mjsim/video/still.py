"""One picture of a world before its robots move: from an onboard camera, or from outside."""

from pathlib import Path

from mjsim.errors import UsageError, did_you_mean
from mjsim.interface import Picture
from mjsim.output import require_free
from mjsim.sentences import Sentence
from mjsim.sim import SEEN_FROM_OUTSIDE, Onlooker, Playback, Simulation
from mjsim.video.ink import write_picture
from mjsim.video.picture_layout import HEIGHT, WIDTH
from mjsim.world import Camera, World

OVERVIEW, CHASE = "overview", "chase"


def portrait(world: World, *, width: int, height: int) -> Picture:
    """Return a picture of everything on the floor of a world, as large as possible, RGB, (height, width, 3).

    Args:
        world: World that contains only what to show.
        width: [px]
        height: [px]

    Raises:
        UsageError: There is nothing on the floor.
        OpenGLError: Rendering is not possible on this machine.
    """
    # The state is that after the robots have settled on their wheels.
    with Simulation(world) as sim:
        qpos, _ = sim.state()
    with Onlooker(world) as onlooker:
        onlooker.show(qpos, None)
        return onlooker.portrait(width=width, height=height)


def take_picture(world: World, camera: str, path: Path | None = None, *, overwrite: bool = False) -> Picture:
    """Return the picture of a camera at the start, RGB, shape (height, width, 3), and write it if a path is given.

    Args:
        world: The world.
        camera: 'ROBOT/CAMERA', 'PERSON/left_eye' or 'PERSON/right_eye'; or from outside, 'ROBOT/chase' (behind a robot)
            or 'overview'.
        path: PNG or JPEG file to write as well.
        overwrite: Whether an existing file may be replaced.

    Raises:
        UsageError: The camera does not exist, or the file exists or cannot be written.
        OpenGLError: Rendering is not possible on this machine.
    """
    if path is not None:
        require_free(path, overwrite=overwrite)
    outside = [OVERVIEW, *(f"{robot.name}/{CHASE}" for robot in world.robots)]
    outside += [f"{person.name}/{side}_eye" for person in world.people for side in ("left", "right")]
    onboard = [
        f"{robot.name}/{sensor.camera}"
        for robot in world.robots
        for sensor in robot.sensors
        if isinstance(sensor, Camera)
    ]
    if camera not in outside + onboard:
        raise UsageError(
            Sentence(
                "no camera '{camera}' in this world{did_you_mean}", camera, did_you_mean(camera, onboard + outside)
            )
        )
    picture = _seen_onboard(world, camera) if camera in onboard else _seen_from_outside(world, camera)
    if path is not None:
        write_picture(path, picture, overwrite=overwrite)
    return picture


def _seen_onboard(world: World, camera: str) -> Picture:
    robot, _, name = camera.partition("/")
    with Simulation(world) as sim:
        seen = sim.sense(robot)
        while name not in seen.cameras:  # its first picture is delayed by the latency
            sim.step()
            seen = sim.sense(robot)
        return seen.cameras[name].image.copy()


def _seen_from_outside(world: World, camera: str) -> Picture:
    with Simulation(world) as sim:
        qpos, _ = sim.state()
        events = sim.happened()
    with Playback(
        world, width=WIDTH, height=HEIGHT, quality="high", groups=SEEN_FROM_OUTSIDE, events=events
    ) as playback:
        return playback.picture(qpos, camera, time=0.0).copy()
