"""Simulated movers: obstacles placed on their routes at every physics step."""

import mujoco
import numpy as np

from mjsim.world import Route, World, item_names, route_of


class Movers:
    """Sets the movers of a world to their positions at a time, with the velocity for contacts."""

    def __init__(self, model: mujoco.MjModel, data: mujoco.MjData, world: World) -> None:
        """Find the slides of the movers in the compiled world."""
        self._data = data
        self._routes: list[Route] = []
        self._starts: list[tuple[float, ...]] = []
        places, speeds = [], []
        for obstacle, name in zip(world.obstacles, item_names(world.obstacles), strict=True):
            route = route_of(obstacle)
            if route is None:
                continue
            joints = [model.joint(f"obstacle/{name}/{axis}") for axis in "xy"]
            self._routes.append(route)
            self._starts.append(obstacle.at)
            places += [joint.qposadr[0] for joint in joints]
            speeds += [joint.dofadr[0] for joint in joints]
        self._places, self._speeds = np.array(places, dtype=int), np.array(speeds, dtype=int)

    def __len__(self) -> int:
        """Return the number of movers."""
        return len(self._routes)

    def put(self, time: float) -> None:
        """Set all to their positions at a time [s]."""
        if not self._routes:
            return
        found = np.array([route.at(time) for route in self._routes])
        self._data.qpos[self._places] = (found[:, 0] - self._starts).ravel()
        self._data.qvel[self._speeds] = found[:, 1].ravel()
