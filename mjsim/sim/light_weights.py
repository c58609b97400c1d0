"""How bright each group of lights is, read from a compiled world and its state."""

import mujoco
import numpy as np
from numpy.typing import NDArray

from mjsim.compile import general_light, lamp_brightness
from mjsim.geometry import Array
from mjsim.light import DOOR, GENERAL, LAMP, BakedLight, linear

DOOR_STEPS = 32
"""Steps of light between a closed and an open door."""


class LightWeights:
    """Weights of the groups of light in the current state of a model; what events change is in the model itself."""

    def __init__(self, model: mujoco.MjModel, baked: BakedLight) -> None:
        """Find lamps and doors by the names of the groups."""
        self._model = model
        self._weights = baked.weights()
        names = [group.name for group in baked.groups]
        self._general = [place for place, name in enumerate(names) if name == GENERAL]
        self._lamps = [place for place, name in enumerate(names) if name.startswith(LAMP)]
        self._lights = np.array([model.light(names[place]).id for place in self._lamps], dtype=int)
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
            weights[self._lamps] = linear(brightness)
            weights[self._doors] = opened[:, None] / DOOR_STEPS
            self._weights = weights
        return self._weights
