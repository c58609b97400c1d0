"""Functions that draw arms, by name, and figures as they are while a script moves them."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from mjsim.geometry import Array
from mjsim.toolbox.calls import FigureCall
from mjsim.toolbox.draw import Drawing, ScriptFigures
from mjsim.toolbox.panes import ArmMotion, AxesPane, draw_motion
from mjsim.toolbox.script_arms import arm_of

STYLES_OF_ARMS = (
    *("scale", "mag", "jointdiam", "jointcolor", "jointlen", "linkcolor", "tilesize", "tile1color", "tile2color"),
    *(
        "delay",
        "fps",
        "loop",
        "movie",
        "floorlevel",
        "basewidth",
        "basecolor",
        "ortho",
        "perspective",
        "shadow",
        "joints",
    ),
    *("noshadow", "shading", "noshading", "jaxes", "nojaxes", "jvec", "nojvec", "base", "nobase", "tiles", "notiles"),
    *("wrist", "nowrist", "wristlabel", "arrow", "noarrow", "name", "nojoints", "raise", "noraise", "trail", "zoom"),
    *(
        "xyz",
        "noa",
        "cylinder",
        "erase",
        "lightpos",
        "shadowcolor",
        "toolframe",
        "top",
        "erasemode",
        "frame",
        "path",
        "joints",
    ),
)
"""Options of pictures of arms that have no effect here."""


def _drive(drawn: ScriptFigures, call: FigureCall) -> None:
    """Store the arm of the sliders, and draw it into a figure of its own."""
    drawn.driven, drawn.start = call.arguments[0], np.ravel(call.arguments[1])
    is_free = call.figure in drawn.figures and not drawn.figures[call.figure].axes
    _robot(drawn, call if is_free else replace(call, figure=max(drawn.figures, default=0) + 1))


def _robot(drawn: ScriptFigures, call: FigureCall) -> None:
    """Add postures of an arm; successive ones of the same arm are one motion."""
    fields, q = call.arguments[0], np.atleast_2d(call.arguments[1])
    arm = arm_of(fields)
    if q.shape[1] != arm.n:
        raise ValueError(f"q has {q.shape[1]} columns; the arm has {arm.n} joints")
    pane = drawn.pane(call.figure, solid=True)
    motions = drawn.motions.setdefault(call.figure, [])
    same = next((m for m in motions if m.pane is pane and m.arm.name == arm.name and m.arm.n == arm.n), None)
    if same is None:
        if not pane.hold:
            pane = drawn.cleared(call.figure, solid=True)
        same = ArmMotion(arm, fields, pane=pane)
        drawn.motions.setdefault(call.figure, []).append(same)
    same.q.append(q)
    assert same.pane is not None
    _options(drawn, replace(call, arguments=call.arguments[2:]), same.pane)


def _options(drawn: ScriptFigures, call: FigureCall, pane: AxesPane) -> None:
    """Store the workspace and the view for pictures of an arm; report unknown options."""
    options = list(call.arguments)
    while options:
        word = options.pop(0)
        if not isinstance(word, str):
            continue
        if word == "workspace" and options:
            pane.settings.append(replace(call, name="axis", arguments=(options.pop(0),)))
        elif word == "view" and options and isinstance(options[0], np.ndarray):
            pane.settings.append(replace(call, name="view", arguments=(options.pop(0),)))
        elif word == "noname":
            pane.axes.set_title(" ")
        elif word.removeprefix("no") not in STYLES_OF_ARMS and word not in STYLES_OF_ARMS and len(word) > 2:
            drawn.skipped.add(f"plot of an arm: it has no option '{word}'")


def drawn_now(drawn: ScriptFigures, number: int) -> Array:
    """Return a picture of a figure as it is now, with arms at their last postures, shape (height, width, 3), uint8."""
    figure: Any = drawn.figure(number)
    shown = [(motion, motion.pane.axes) for motion in drawn.motions.get(number, []) if motion.pane is not None]
    before = [{*axes.get_children()} for _, axes in shown]
    for motion, _ in shown:
        draw_motion(motion, motion.q[-1][-1:])
    figure.canvas.draw()
    picture = np.asarray(figure.canvas.buffer_rgba())[:, :, :3].copy()
    for (_, axes), kept in zip(shown, before, strict=True):
        for artist in (*axes.lines, *axes.texts):
            if artist not in kept:
                artist.remove()
    return picture


ARM_FUNCTIONS: Mapping[str, Drawing] = {"robot": _robot, "drive": _drive}
"""Functions that draw, by the names of their calls."""
