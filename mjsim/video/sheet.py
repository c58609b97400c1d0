"""The plan of a world as a sheet of paper, as drawn by `mjsim show`, for printing at a round scale."""

import math
from pathlib import Path
from typing import Literal

import numpy as np

from mjsim.geometry import Array, Pose
from mjsim.interface import Picture
from mjsim.output import require_free
from mjsim.posture import poses_of
from mjsim.video.arms import draw_arm
from mjsim.video.diagrams import diagrams_page
from mjsim.video.figures import draw_figure, people_page
from mjsim.video.ink import BEACON, INK, MUTED, PAPER, SEEN, SEMIBOLD, TRUTH, blend
from mjsim.video.legend import draw_legend
from mjsim.video.mechanisms import ABOVE, draw_mechanism, posed
from mjsim.video.names import Tag, write_tags
from mjsim.video.paper import Paper, blank, px, write_sheet
from mjsim.video.plan import MAX_NAMES, world_bounds
from mjsim.video.symbols import (
    LEAST_ROBOT,
    draw_beacon,
    draw_door,
    draw_lamp,
    draw_low_wall,
    draw_obstacle,
    draw_patch,
    draw_path,
    draw_robot,
    draw_wall,
    leaf_path,
    swing,
)
from mjsim.video.view import PlanView, format_metres, round_step
from mjsim.world import RampObstacle, StepsObstacle, Wall, World, footprint, hung, leaves, top

A4 = (297.0, 210.0)
"""Length and width of the paper [mm]."""
LEFT, TOP, RIGHT, BOTTOM = 17.0, 21.0, 9.0, 21.0
"""Margins around the plan, for axis, title, edge, axis and legend [mm]."""
AROUND = 5.0
"""Free space around the outermost walls [mm]."""
LEAST = 120.0
"""Minimum width of a sheet, for title and legend [mm]."""
CROWDED = 0.025
"""Obstacle names are omitted, unless requested, if they would cover a larger fraction of the plan."""
SCALES = (1.0, 1.25, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 7.5)
"""Scale denominators are these times a power of ten."""


Labels = Literal["none", "walls", "all"]


def draw_world(
    world: World,
    path: str | Path | None = None,
    *,
    names: bool = True,
    labels: Labels | None = None,
    overwrite: bool = False,
) -> Picture:
    """Draw the plan of a world for print: at most A4, at a round scale, with coordinates and names.

    Below it are kinematic diagrams of mechanisms, each to its own scale, and people from the right and from above.

    Args:
        world: The world.
        path: PNG or JPEG file to write as well.
        names: Whether to write names.
        labels: Names to write: none, those of walls, or all; by default those of robots, beacons, doors and lamps, and
            those of obstacles if there is space.
        overwrite: Whether an existing file may be replaced.

    Returns:
        RGB picture with `DPI` pixels per inch.

    Raises:
        UsageError: The file exists or cannot be written.
    """
    if path is not None:
        require_free(Path(path), overwrite=overwrite)
    page = plan_page(world, bounds_of(world), labels=labels if names else "none")
    if world.mechanisms:
        page = np.concatenate([page, diagrams_page(world, page.shape[1], names=names and labels != "none")])
    if world.people:
        page = np.concatenate([page, people_page(world, page.shape[1], names=names and labels != "none")])
    if path is not None:
        write_sheet(path, page, overwrite=overwrite)
    return page


def plan_page(world: World, bounds: Array, *, labels: Labels | None = None) -> Picture:
    """Return the sheet with the plan of a world within bounds, shape (2, 2) [m]."""
    ratio = scale_for(bounds)
    sheet = lay_out(bounds, ratio)
    plan = sheet.inner(LEFT, TOP, RIGHT, BOTTOM)
    draw_grid(plan)
    _draw_things(plan, world)
    write_tags(plan, _chosen_tags(plan, world, labels))
    draw_axes(sheet, plan)
    write_head(sheet, world.name, world_bounds(world), ratio)
    draw_legend(sheet, world, left=LEFT, right=RIGHT)
    return sheet.image


def _chosen_tags(plan: Paper, world: World, labels: Labels | None) -> list[Tag]:
    """Return the names to write."""
    if labels == "none" or len(world.beacons) + len(world.obstacles) > MAX_NAMES:
        return []
    walls = [_wall_tag(plan, wall) for wall in world.walls if wall.name is not None]
    if labels == "walls":
        return walls
    tags, things = _tags(plan, world), _thing_tags(plan, world)
    if labels == "all":
        return [*tags, *things, *walls]
    room = plan.image.shape[0] * plan.image.shape[1]
    ink = sum(plan.letters.width(tag.text, round(px(tag.size))) * px(tag.size) for tag in things)
    return tags if ink > CROWDED * room else [*tags, *things]


def scale_for(bounds: Array) -> float:
    """Return the smallest round N for which a world within bounds [m] fits on A4 at a scale of 1 : N."""
    size = (bounds[1] - bounds[0]) * 1000.0
    fits = []
    for length, width in (A4, A4[::-1]):
        room = np.array([length - LEFT - RIGHT, width - TOP - BOTTOM]) - 2 * AROUND
        fits.append(float(np.max(size / room)))
    power = 10.0 ** math.floor(math.log10(min(fits)) + 1e-9)
    return next(step * power for step in (*SCALES, 10.0) if step * power >= min(fits) * (1 - 1e-9))


def bounds_of(world: World) -> Array:
    """Return minimum and maximum of (x, y) of everything drawn, shape (2, 2) [m]."""
    points = [world_bounds(world)]
    points += [leaf_path(leaf, swing(world, leaf)) for leaf in leaves(world)]
    points += [np.array([lamp.at]) for lamp in world.lamps] + [patch.outline() for patch in world.floor.patches]
    points += [np.array(item.path.points) for item in world.obstacles if item.path is not None]
    found = np.concatenate(points)
    return np.stack([found.min(axis=0), found.max(axis=0)])


def lay_out(bounds: Array, ratio: float) -> Paper:
    """Return an empty sheet for a plan with given bounds and scale."""
    scale = px(1000.0) / ratio
    size = (bounds[1] - bounds[0]) * scale + 2 * px(AROUND)
    width = max(float(size[0]) + px(LEFT + RIGHT), px(LEAST))
    left = bounds[0, 0] - (px(LEFT) + (width - px(LEFT + RIGHT) - (size[0] - 2 * px(AROUND))) / 2) / scale
    above = bounds[1, 1] + px(TOP + AROUND) / scale
    return blank(PlanView(float(left), float(above), scale, math.ceil(width), math.ceil(size[1] + px(TOP + BOTTOM))))


def _draw_things(plan: Paper, world: World) -> None:
    """Draw everything in the world, from the floor up."""
    for patch in world.floor.patches:
        draw_patch(plan, patch)
    for wall in world.walls:
        draw_low_wall(plan, wall)
    for obstacle in sorted(world.obstacles, key=top):
        draw_obstacle(plan, obstacle)
    for wall in world.walls:
        draw_wall(plan, wall)
    for leaf in leaves(world):
        draw_door(plan, leaf, opens_to=swing(world, leaf))
    for obstacle in world.obstacles:
        draw_path(plan, obstacle)
    for lamp in world.lamps:
        draw_lamp(plan, lamp)
    for mechanism in world.mechanisms:
        draw_mechanism(plan, posed(mechanism, mechanism.assembly.start))
    for person in world.people:
        draw_figure(plan, person, poses_of(world, person), ABOVE)
    for robot in world.robots:
        draw_robot(plan, robot)
        for arm in robot.arms:
            draw_arm(plan, arm, Pose(robot.at[0], robot.at[1], math.radians(robot.heading_deg)))
    for item in hung(world):
        draw_beacon(plan, item.beacon, item.place)


def _tags(plan: Paper, world: World) -> list[Tag]:
    """Return the names of everything except obstacles and walls, in order of priority."""
    below, tags = np.array([0.0, -1.0]), []
    for robot in world.robots:
        reach = (max(robot.body.radius, plan.metres(LEAST_ROBOT)),) * 2
        tags.append(Tag(text=robot.name, at=np.array(robot.at), side=below, reach=reach, color=INK, size=2.8))
    for item in hung(world):
        beacon, place = item.beacon, item.place
        ahead = np.array([math.cos(place.heading), math.sin(place.heading)])
        color = blend(TRUTH if beacon.image is None and beacon.marker is None else BEACON, INK, 0.5)
        color = blend(SEEN, INK, 0.5) if beacon.marker is not None else color
        at = np.array([place.x, place.y])
        tags.append(Tag(text=beacon.name, at=at, side=ahead, reach=(plan.metres(1.2),) * 2, color=color))
    named = {opening.name for wall in world.walls for opening in wall.openings}
    for leaf in leaves(world):
        if leaf.name in named:
            middle = leaf_path(leaf, 0.0)[0] / 2 + np.array(leaf.hinge) / 2
            left = leaf.turn * np.array([-math.sin(leaf.closed), math.cos(leaf.closed)])
            tags.append(Tag(text=leaf.name, at=middle, side=left, reach=(0.06, 0.06), color=MUTED))
    for mechanism in world.mechanisms:
        low, high = mechanism.spanned()[:, :2]
        reach = ((high[0] - low[0]) / 2, (high[1] - low[1]) / 2 + plan.metres(3.0))
        tags.append(Tag(text=mechanism.name, at=(low + high) / 2, side=below, reach=reach, color=INK))
    for person in world.people:
        reach, place = (0.3, 0.3), person.place()
        tags.append(Tag(text=person.name, at=np.array([place.x, place.y]), side=below, reach=reach, color=INK))
    for lamp in world.lamps:
        if lamp.name is not None:
            tags.append(
                Tag(text=lamp.name, at=np.array(lamp.at), side=below, reach=(plan.metres(1.8),) * 2, color=MUTED)
            )
    return tags


def _thing_tags(plan: Paper, world: World) -> list[Tag]:
    """Return the names of obstacles."""
    things = [(item, item.name) for item in world.obstacles if item.name is not None]
    return [_obstacle_tag(plan, name, footprint(item), _slope(item)) for item, name in things]


def _wall_tag(plan: Paper, wall: Wall) -> Tag:
    """Return the name of a wall, beside the centre of its longest segment."""
    start, end = max(wall.segments(), key=lambda ends: math.dist(*ends))
    along = np.subtract(end, start) / math.dist(start, end)
    side = np.array([-along[1], along[0]])
    reach = (wall.thickness / 2 + plan.metres(0.5),) * 2
    return Tag(text=wall.name or "", at=np.add(start, end) / 2, side=side, reach=reach, color=MUTED)


def _slope(obstacle: object) -> str:
    """Return a text on the slope of a ramp or steps, added to the name."""
    match obstacle:
        case RampObstacle(ramp=(length, _, rise)):
            return f" {math.degrees(math.atan2(rise, length)):.1f}\N{DEGREE SIGN}"
        case StepsObstacle(steps=(_, _, rise), count=count):
            return f" {count} \N{MULTIPLICATION SIGN} {rise / count * 100:.0f} cm"
    return ""


def _obstacle_tag(plan: Paper, name: str, outline: Array, more: str) -> Tag:
    low, high = np.min(outline, axis=0), np.max(outline, axis=0)
    middle, size = (low + high) / 2, high - low
    width = plan.letters.width(name + more, round(px(2.3))) / plan.view.scale
    inside = width < size[0] and plan.metres(3.0) < size[1] and not more
    side = np.array([0.0, 0.0 if inside else -1.0])
    return Tag(text=name + more, at=middle, side=side, reach=(size[0] / 2, size[1] / 2), color=MUTED)


def draw_grid(plan: Paper) -> None:
    """Draw the grid: a line at each number on the axes, fainter lines between."""
    coarse = _axis_step(plan.view)
    for step, share in ((coarse / 2 if coarse > 0.5 else coarse / 5, 0.93), (coarse, 0.86)):
        color = blend(INK, PAPER, share)
        for x in np.arange(math.ceil(plan.view.left / step), plan.view.right / step) * step:
            plan.line([(x, plan.view.bottom), (x, plan.view.top)], color, 0.1)
        for y in np.arange(math.ceil(plan.view.bottom / step), plan.view.top / step) * step:
            plan.line([(plan.view.left, y), (plan.view.right, y)], color, 0.1)


def _axis_step(view: PlanView) -> float:
    return round_step(px(9.0) / view.scale)


def draw_axes(sheet: Paper, plan: Paper) -> None:
    """Draw the frame, and coordinates along its left and lower edge."""
    view, step, page, letters = plan.view, _axis_step(plan.view), sheet.image, sheet.letters
    left, right, bottom, high = px(LEFT), px(LEFT) + view.width, px(TOP) + view.height, px(TOP)
    size = round(px(2.3))
    frame = sheet.view.world([[left, high], [right, high], [right, bottom], [left, bottom]])
    sheet.line(frame, MUTED, 0.15, closed=True)
    for x in np.arange(math.ceil(view.left / step), view.right / step) * step:
        column = float(sheet.view.pixels((x, 0.0))[0])
        sheet.line(sheet.view.world([[column, bottom], [column, bottom + px(1.0)]]), MUTED, 0.15)
        letters.write(page, format_metres(x, step), (column, bottom + px(3.6)), size, MUTED, align=0.5)
    for y in np.arange(math.ceil(view.bottom / step), view.top / step) * step:
        row = float(sheet.view.pixels((0.0, y))[1])
        sheet.line(sheet.view.world([[left - px(1.0), row], [left, row]]), MUTED, 0.15)
        letters.write(page, format_metres(y, step), (left - px(1.8), row + px(0.8)), size, MUTED, align=1.0)
    letters.write(page, "x east [m]", (right, bottom + px(7.2)), size, MUTED, align=1.0)
    letters.write(page, "y north [m]", (px(4.0), high - px(2.4)), size, MUTED)


def write_head(sheet: Paper, title: str, bounds: Array, ratio: float) -> None:
    """Write title and size at the left, scale bar and north arrow at the right."""
    letters, page, right = sheet.letters, sheet.image, sheet.view.width - px(RIGHT)
    letters.write(page, title, (px(LEFT), px(10.5)), round(px(5.2)), INK, weight=SEMIBOLD)
    metres = " \N{MULTIPLICATION SIGN} ".join(
        format_metres(round(value, 1), 0.1) for value in np.ptp(bounds, axis=0).tolist()
    )
    letters.write(page, f"{metres} m, 1 : {ratio:g}", (px(LEFT), px(15.2)), round(px(2.6)), MUTED)
    _draw_north(sheet, right - px(3.0), px(5.5))
    _draw_scale(sheet, right - px(11.0), px(11.5))


def _draw_north(sheet: Paper, x: float, y: float) -> None:
    sheet.arrow(sheet.view.world([[x, y + px(7.5)], [x, y]]), INK, 0.3)
    sheet.letters.write(sheet.image, "N", (x, y - px(0.6)), round(px(2.6)), INK, weight=SEMIBOLD, align=0.5)


def _draw_scale(sheet: Paper, right: float, y: float) -> None:
    """Draw a scale bar of four parts, black and white, labelled at its ends and centre."""
    part = round_step(px(7.0) / sheet.view.scale)
    width = part * sheet.view.scale
    left = right - 4 * width
    for number in range(4):
        x = left + number * width
        box = sheet.view.world([[x, y], [x + width, y], [x + width, y + px(1.2)], [x, y + px(1.2)]])
        sheet.fill(box, PAPER if number % 2 else INK)
        sheet.line(box, INK, 0.15, closed=True)
    for number in (0, 2, 4):
        text = f"{number * part:g}" + (" m" if number == 4 else "")
        sheet.letters.write(sheet.image, text, (left + number * width, y - px(1.0)), round(px(2.3)), MUTED, align=0.5)
