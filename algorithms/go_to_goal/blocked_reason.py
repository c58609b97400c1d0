"""Tells in a sentence why a robot does not get nearer to its goal."""

import math

from mjsim.geometry import Array


def reason(goal: Array, *, turns: bool, parks: bool, slips: bool, jammed: bool, barred: bool) -> str:
    """Return why.

    Args:
        goal: x, y [m] and heading [rad], NaN for any.
        turns: Whether it is there, but cannot turn to the heading.
        parks: Whether it searches a path to the heading.
        slips: Whether its wheels slip.
        jammed: Whether every motion collides.
        barred: Whether there is no way.
    """
    x, y, heading = goal.tolist()
    if turns:
        return f"no room to turn to {math.degrees(heading):g} degrees at [{x:g}, {y:g}]; waiting for space"
    if parks:
        return f"no path to [{x:g}, {y:g}] at {math.degrees(heading):g} degrees found yet; still searching"
    if slips:
        return f"the wheels turn, but the sensors see no motion; still trying to get to [{x:g}, {y:g}]"
    if jammed:
        return f"every motion would touch something; still trying to get to [{x:g}, {y:g}]"
    if barred:
        return f"no path to [{x:g}, {y:g}] between the obstacles seen so far; still searching"
    return f"no progress towards [{x:g}, {y:g}]; trying other ways"
