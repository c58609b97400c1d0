"""Writes designs as modules: the keys of a world with which a design controls the plant."""

from mjsim.lab.design import Design
from mjsim.lab.linear import LinearPlant
from mjsim.world import Plant

MODULE = "mjsim.algorithms.linear_control"
EFFORTS = {"N": "force", "N m": "torque"}
"""Actuators by the unit of a plant's input."""
BALANCE = ("way", "lean", "way.rate", "lean.rate")


def module_text(plant: Plant, linear: LinearPlant, design: Design) -> str:
    """Return the keys of a world with which a design controls a plant, or a description of the design if impossible.

    These are keys below `run:` for robots and arms, and an actuator for mechanisms.
    """
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
    if (effort := EFFORTS.get(linear.units[0])) and linear.input in linear.states:
        return _actuator_text(effort, plant, linear, design)
    return f"# a controller: {law}\n"


def _actuator_text(effort: str, plant: Plant, linear: LinearPlant, design: Design) -> str:
    """Return the actuator of a mechanism; a series controller feeds back the first output, the actuated joint's."""
    joint, about = linear.input, ""
    if not design.gain:
        if linear.outputs[0] != joint:
            return f"# a controller: {_law(design)}\n"
        law = _law(design)
    else:
        gains = dict(zip(linear.states, design.gain, strict=True))
        pairs = (
            f"{name}: [{value:.9g}, {gains[f'{name}.rate']:.9g}]" for name, value in gains.items() if "rate" not in name
        )
        law = f"gain: {{{', '.join(pairs)}}}"
        for key in ("about", "about_deg"):
            ends = {
                n.removesuffix("_deg"): v for n, v in plant.around.items() if n.endswith("_deg") == (key != "about")
            }
            rest = ", ".join(f"{name}: {value:g}" for name, value in ends.items())
            about += f", {key}: {{{rest}}}" if rest else ""
    use = f'{{use: "{MODULE}:MechanismLoop", {law}{about}}}'
    return f"actuators:\n  - {effort}: {joint}\n    controller: {use}\n"


def _reference(linear: LinearPlant) -> str:
    return "{to_deg: 30}" if linear.input == "turn" else "{to: 0.3}"


def _law(design: Design) -> str:
    if design.gain:
        return f"gain: [{', '.join(f'{value:.9g}' for value in design.gain)}]"
    num, den = (", ".join(f"{value:.9g}" for value in part) for part in (design.num, design.den))
    return f"num: [{num}], den: [{den}]"
