"""Controllers as modules: what to write into a world so that a design drives the plant."""

from mjsim.lab.design import Design
from mjsim.lab.linear import LinearPlant
from mjsim.world import Plant

MODULE = "mjsim.algorithms.linear_control"
BALANCE = ("way", "lean", "way.rate", "lean.rate")


def module_text(plant: Plant, linear: LinearPlant, design: Design) -> str:
    """Return what stands below `run:` so that a design drives a plant, or the design in words where nothing can."""
    robot, _, part = (plant.of or "").partition("/")
    law = _law(design)
    if part and plant.input is not None:
        use = f'{{use: "{MODULE}:JointLoop", joint: {plant.input}, {law}}}'
        return f"run:\n  drivers:\n    {robot}:\n      controllers: {{{part}: {use}}}\n"
    if linear.input == "torque" and linear.states == BALANCE and design.gain:
        use = f'{{use: "{MODULE}:StateFeedback", {law}}}'
        return f"run:\n  drivers:\n    {robot}:\n      controllers: {{drive: {use}}}\n"
    if linear.input in ("forward", "turn") and design.num:
        use = f'{{use: "{MODULE}:SpeedLoop", of: {linear.input}, {law}, reference: {{step: {_reference(linear)}}}}}'
        return f"run:\n  drivers:\n    {robot}:\n      navigator: {use}\n"
    return f"# a controller: {law}\n"


def _reference(linear: LinearPlant) -> str:
    return "{to_deg: 30}" if linear.input == "turn" else "{to: 0.3}"


def _law(design: Design) -> str:
    if design.gain:
        return f"gain: [{', '.join(f'{value:.9g}' for value in design.gain)}]"
    num, den = (", ".join(f"{value:.9g}" for value in part) for part in (design.num, design.den))
    return f"num: [{num}], den: [{den}]"
