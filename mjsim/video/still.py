"""One picture of a world: what an onboard camera sees before the robot moves."""

from pathlib import Path

from mjsim.errors import UsageError, did_you_mean
from mjsim.interface import Picture
from mjsim.sim import Simulation
from mjsim.video.ink import write_picture
from mjsim.world import World
from mjsim.world.sensors import Camera


def take_picture(world: World, camera: str, path: Path | None = None) -> Picture:
    """Return what a camera sees at the start, RGB, shape (height, width, 3), and write it if a path is given.

    Args:
        world: Where its robot stands.
        camera: 'ROBOT/CAMERA'.
        path: PNG or JPEG file to write as well.

    Raises:
        UsageError: There is no such camera, or the file cannot be written.
        OpenGLError: Nothing can be drawn on this machine.
    """
    known = [
        f"{robot.name}/{sensor.camera}"
        for robot in world.robots
        for sensor in robot.sensors
        if isinstance(sensor, Camera)
    ]
    if camera not in known:
        raise UsageError(f"no camera '{camera}' in this world{did_you_mean(camera, known)}")
    robot, _, name = camera.partition("/")
    with Simulation(world) as sim:
        picture = sim.sense(robot).cameras[name].image.copy()
    if path is not None:
        write_picture(path, picture)
    return picture
