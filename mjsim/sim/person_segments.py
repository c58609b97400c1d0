"""Which bodies of a model are segments of people."""

import mujoco

UPPER = (
    *("abdomen", "thorax", "neck", "head"),
    *("left_upper_arm", "left_forearm", "left_hand", "right_upper_arm", "right_forearm", "right_hand"),
)
"""Segments that move with a hand; hips and legs do not move."""


def is_segment(model: mujoco.MjModel, body: int) -> bool:
    """Return whether a body is a segment of a person."""
    person, _, _ = model.body(body).name.rpartition("/")
    pelvis = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, f"{person}/pelvis")
    # Nothing else has a body of that name with a neck attached.
    return bool(pelvis > 0 and mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, f"{person}/neck") > 0)


def is_upper(model: mujoco.MjModel, body: int) -> bool:
    """Return whether a body is a segment of a person that moves when a hand does."""
    person, _, segment = model.body(body).name.rpartition("/")
    return segment in UPPER and mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, f"{person}/pelvis") > 0
