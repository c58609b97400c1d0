"""A compiled model as it was before a run changed it."""

import mujoco

CHANGED = (
    "body_conaffinity",
    "body_contype",
    "body_quat",
    "eq_data",
    "geom_conaffinity",
    "geom_contype",
    "geom_group",
    "light_active",
    "light_ambient",
    "light_diffuse",
    "mat_emission",
    "numeric_data",
    "site_pos",
)
"""What a run changes of a model: what is taken away, hands of people, locks of doors, lamps and light, what constraints
aim at."""
HEADLIGHT = ("ambient", "diffuse")


class Snapshot:
    """Keeps what a run may change of a model; large things, such as meshes and pictures, are not copied."""

    def __init__(self, model: mujoco.MjModel) -> None:
        """Copy it."""
        self._values = {name: getattr(model, name).copy() for name in CHANGED}
        self._headlight = {name: getattr(model.vis.headlight, name).copy() for name in HEADLIGHT}

    def restore(self, model: mujoco.MjModel) -> None:
        """Write it back."""
        for name, value in self._values.items():
            getattr(model, name)[:] = value
        for name, value in self._headlight.items():
            getattr(model.vis.headlight, name)[:] = value
