"""A compiled model as it was before a run changed it."""

import mujoco

CHANGED_FIELDS = (
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
"""Fields of a model that a run changes: removed objects, hands of people, locks of doors, lamps and light, targets of
constraints."""
HEADLIGHT_FIELDS = ("ambient", "diffuse")


class Snapshot:
    """Keeps the fields of a model that a run may change; large ones, such as meshes and textures, are not copied."""

    def __init__(self, model: mujoco.MjModel) -> None:
        """Copy the fields."""
        self._values = {name: getattr(model, name).copy() for name in CHANGED_FIELDS}
        self._headlight = {name: getattr(model.vis.headlight, name).copy() for name in HEADLIGHT_FIELDS}

    def restore(self, model: mujoco.MjModel) -> None:
        """Restore the fields."""
        for name, value in self._values.items():
            getattr(model, name)[:] = value
        for name, value in self._headlight.items():
            getattr(model.vis.headlight, name)[:] = value
