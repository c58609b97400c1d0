"""How bright each group of lights is, read from a compiled world and its state."""

import mujoco
import numpy as np
from numpy.typing import NDArray

from mjsim.compile import general_light, lamp_brightness, lamp_lights
from mjsim.geometry import Array
from mjsim.light import DOOR, GENERAL, LAMP, BakedLight, linear
from mjsim.progress import say

DOOR_STEPS = 32
"""Steps of light between a closed and an open door."""


class LightWeights:
    """Weights of the groups of light in the current state of a model; changes by events are in the model itself."""

    def __init__(self, model: mujoco.MjModel, baked: BakedLight) -> None:
        """Find lamps and doors by the names of the groups."""
        self._model = model
        self._weights = baked.weights()
        names = [group.name for group in baked.groups]
        self._general = [place for place, name in enumerate(names) if name == GENERAL]
        self._lamps = [place for place, name in enumerate(names) if name.startswith(LAMP)]
        own = np.array([model.light(names[place]).id for place in self._lamps], dtype=int)
        # Lamps with a map of their own first.
        self._lights = np.concatenate([own, np.setdiff1d(lamp_lights(model), own)])
        self._start = lamp_brightness(model, self._lights)
        self._doors = [place for place, name in enumerate(names) if name.startswith(DOOR)]
        self._hinges = np.array([model.joint(names[place]).qposadr[0] for place in self._doors], dtype=int)
        angles = np.array([baked.groups[place].angle for place in self._doors])
        # A door that events only close has no angle, and no light of its own.
        self._openings = np.divide(1.0, angles, out=np.zeros(len(angles)), where=angles != 0.0)
        self._told: tuple[float, bytes, bytes] | None = None

    def of(self, data: mujoco.MjData) -> Array:
        """Return the weights in a state, shape (groups, 3); the same array until they change."""
        opened = np.rint(np.clip(data.qpos[self._hinges] * self._openings, 0.0, 1.0) * DOOR_STEPS)
        brightness: NDArray[np.float64] = lamp_brightness(self._model, self._lights)
        level = general_light(self._model)
        told = level, brightness.tobytes(), opened.tobytes()
        if told != self._told:
            self._told = told
            weights = self._weights.copy()
            weights[self._general] = linear(level)
            weights[self._lamps] = linear(brightness[: len(self._lamps)])
            self._tell_of_shared(brightness)
            weights[self._doors] = opened[:, None] / DOOR_STEPS
            self._weights = weights
        return self._weights

    def _tell_of_shared(self, brightness: Array) -> None:
        """Warn once that a lamp has changed whose light shares a map with others."""
        changed = (brightness != self._start).any(axis=1)
        changed[: len(self._lamps)] = False
        if changed.any():
            self._start = brightness
            name = self._model.light(int(self._lights[changed.argmax()])).name.removeprefix(LAMP)
            say(
                f"lamp '{name}' shares a light map with others, so its change does not show;"
                f" name it in an event of the world, or set shading: plain"
            )
