"""Print the figures of sitting, reaching and seeing: contacts, agreement of two solvers, reach, rays of two libraries.

python scripts/measure/posture.py
"""

import math
import time
from dataclasses import replace

import mujoco
import numpy as np
from scipy.optimize import least_squares

from mjsim.compile import compile_world
from mjsim.ergonomics import clearances, collisions, hiders, points_on, studies
from mjsim.people import SEXES, Figure, Measures
from mjsim.posture import Goals, Sitter, Workstation, limits
from mjsim.world import DisplayTarget, World, load_checked, with_settings

WORLDS = ("driving_seat", "forklift", "control_desk")
PERCENTILES = (5.0, 50.0, 95.0)
WEIGHT = 2e3
"""Of a contact for the second solver, as for the first."""
TOO_FAR = 1.2
"""How much farther ahead the right hand is asked to be [m]."""
AROUND = 256
"""Sides of what is round, for Embree: it is thinner by 8e-5 of its radius."""


def other_posture(sitter: Sitter, goals: Goals) -> np.ndarray:
    """Return the joints of the same posture by scipy's bounded least squares, shape (nq,) [rad, m]."""
    model, data = sitter.model, mujoco.MjData(sitter.model)
    contacts, weights, wanted = list(sitter.contacts(goals)), sitter.preference.weights, sitter.preference.values

    def brought(values: np.ndarray) -> tuple[mujoco.MjModel, mujoco.MjData]:
        data.qpos[:] = values
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        return model, data

    def cost(values: np.ndarray) -> np.ndarray:
        state = brought(values)
        return np.concatenate([weights * (values - wanted), *(WEIGHT * each.error(state) for each in contacts)])

    def slope(values: np.ndarray) -> np.ndarray:
        state = brought(values)
        return np.vstack([np.diag(weights), *(WEIGHT * each.jacobian(state) for each in contacts)])

    lower, upper = limits(model)
    begin = np.clip(wanted, lower + 1e-6, upper - 1e-6)
    return np.asarray(least_squares(cost, begin, slope, bounds=(lower, upper), xtol=1e-10, ftol=1e-10).x)


def print_postures(name: str, place: Workstation) -> None:
    """Print contacts, limits and agreement for small, middle and tall women and men on a seat."""
    for sex in SEXES:
        for percentile in PERCENTILES:
            sitter = Sitter(Figure.of(Measures.at_percentile(sex, percentile)), place.seating)
            begin = time.perf_counter()
            found = sitter.sit(place.goals)
            took = 1000 * (time.perf_counter() - begin)
            worst = max((error for key, error in found.errors.items() if key != "gaze"), default=0.0)
            lower, upper = limits(sitter.model)
            values = found.solution.values
            within = bool(np.all((values >= lower - 1e-9) & (values <= upper + 1e-9)))
            angles = sitter.model.jnt_type == mujoco.mjtJoint.mjJNT_HINGE
            apart = np.abs(np.degrees(values - other_posture(sitter, place.goals)))[angles].max()
            print(
                f"{name}, {sex} p{percentile:g}: worst contact {1000 * worst:.2g} mm, within limits: {within}, "
                f"two solvers apart {apart:.2g} deg, {took:.0f} ms, out of reach: {', '.join(found.missed) or 'none'}"
            )


def print_room(name: str, world: World) -> None:
    """Print what small, middle and tall women and men go through, more than 1 cm and not meant."""
    (person,) = world.people
    for sex in SEXES:
        for percentile in PERCENTILES:
            key = f"people.{person.name}"
            placed = with_settings(world, [f"{key}.sex={sex}", f"{key}.percentile={percentile:g}"])
            model = compile_world(placed).compile()
            data = mujoco.MjData(model)
            mujoco.mj_kinematics(model, data)
            found = collisions(clearances(model, data, person.name), placed.people[0])
            through = ", ".join(f"{each.segment} {-1000 * each.distance:.0f} mm into {each.thing}" for each in found)
            print(f"{name}, {sex} p{percentile:g}: goes through {through or 'nothing'}")


def print_too_far(name: str, place: Workstation, figure: Figure) -> None:
    """Print what is said of a hand that is asked too far ahead."""
    if "right" not in place.goals.hands:
        return
    touch, point = place.goals.hands["right"]
    ahead = place.seating.world_from_seat[:3, 0]
    hands = {**place.goals.hands, "right": (touch, point + TOO_FAR * ahead)}
    found = Sitter(figure, place.seating).sit(replace(place.goals, hands=hands))
    rest = max(error for key, error in found.errors.items() if key not in found.missed)
    print(
        f"{name}, right hand {TOO_FAR:g} m too far: out of reach {', '.join(found.missed)} by "
        f"{found.errors['right hand']:.3f} m, the worst of the rest {1000 * rest:.2g} mm"
    )


def revolved(profile: np.ndarray) -> np.ndarray:
    """Return the triangles of a surface around z, shape (n, 3, 3) [m].

    Args:
        profile: Distances from z and heights, from one pole to the other, shape (m, 2) [m].
    """
    turns = 2.0 * np.pi * np.arange(AROUND + 1) / AROUND
    radii, heights = profile[:, 0, None], np.broadcast_to(profile[:, 1, None], (len(profile), AROUND + 1))
    grid = np.stack([radii * np.cos(turns), radii * np.sin(turns), heights], axis=-1)
    a, b, c, d = grid[:-1, :-1], grid[:-1, 1:], grid[1:, 1:], grid[1:, :-1]
    return np.concatenate([np.stack(each, axis=2).reshape(-1, 3, 3) for each in ((a, b, c), (a, c, d))])


def capsule(radius: float, half: float) -> np.ndarray:
    """Return the profile of a capsule, or of a sphere when its half length is 0, shape (m, 2) [m]."""
    tilt = np.linspace(-0.5 * np.pi, 0.5 * np.pi, AROUND)
    return np.column_stack([radius * np.cos(tilt), radius * np.sin(tilt) + np.where(tilt < 0.0, -half, half)])


def cylinder(radius: float, half: float) -> np.ndarray:
    """Return the profile of a cylinder, shape (m, 2) [m]."""
    return np.array([[0.0, -half], [radius, -half], [radius, half], [0.0, half]])


PROFILES = {
    int(mujoco.mjtGeom.mjGEOM_SPHERE): lambda radius, _: capsule(radius, 0.0),
    int(mujoco.mjtGeom.mjGEOM_CAPSULE): capsule,
    int(mujoco.mjtGeom.mjGEOM_CYLINDER): cylinder,
}
"""Of round shapes, by their sizes."""


def triangles_of(model: mujoco.MjModel, data: mujoco.MjData, geom: int) -> np.ndarray:
    """Return the triangles of a shape, nearly of what is round, world frame, shape (n, 3, 3) [m]; none of a plane."""
    if model.geom_type[geom] == mujoco.mjtGeom.mjGEOM_BOX:
        signs = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
        sides = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
        faces = np.array([corner for a, b, c, d in sides for corner in ((a, b, c), (a, c, d))])
        corners = (signs * model.geom_size[geom])[faces]
    elif model.geom_type[geom] == mujoco.mjtGeom.mjGEOM_MESH:
        mesh = model.geom_dataid[geom]
        vertices = slice(model.mesh_vertadr[mesh], model.mesh_vertadr[mesh] + model.mesh_vertnum[mesh])
        faces = slice(model.mesh_faceadr[mesh], model.mesh_faceadr[mesh] + model.mesh_facenum[mesh])
        corners = model.mesh_vert[vertices][model.mesh_face[faces]]
    elif int(model.geom_type[geom]) in PROFILES:
        corners = revolved(PROFILES[int(model.geom_type[geom])](*model.geom_size[geom, :2].tolist()))
    else:
        return np.zeros((0, 3, 3))
    return np.asarray(corners @ data.geom_xmat[geom].reshape(3, 3).T + data.geom_xpos[geom])


def print_rays(name: str, world: World) -> None:
    """Print at how many points of displays Embree and MuJoCo say the same."""
    from embreex.mesh_construction import TriangleMesh
    from embreex.rtcore_scene import EmbreeScene

    model = compile_world(world).compile()
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    solid = model.geom_type != mujoco.mjtGeom.mjGEOM_PLANE
    for study in studies(world):
        head = model.body(f"{study.person.name}/head").id
        shown = np.flatnonzero(solid & (model.geom_group < 3) & (model.geom_bodyid != head))
        parts = [triangles_of(model, data, geom) for geom in shown]
        owner = np.repeat(shown, [len(part) for part in parts])
        scene = EmbreeScene()
        TriangleMesh(scene, np.concatenate(parts).astype(np.float32))
        for target, placed in study.place.targets.items():
            if not isinstance(placed.target, DisplayTarget):
                continue
            points, facing = points_on(placed), placed.world_from_target[:3, 0]
            for eye in study.eyes:
                ours = hiders(model, data, eye, points, facing, head=head)
                way = points - eye.place
                length = np.linalg.norm(way, axis=1)
                starts = np.tile(eye.place, (len(points), 1)).astype(np.float32)
                met = scene.run(starts, (way / length[:, None]).astype(np.float32), output=True)
                theirs = np.where((met["primID"] >= 0) & (met["tfar"] < length - 0.005), owner[met["primID"]], -1)
                asked = ours >= -1
                same = int(np.sum(ours[asked] == theirs[asked]))
                print(
                    f"{name}, {target}, {eye.side} eye: {same} of {int(asked.sum())} points the same, "
                    f"{100 * np.mean(ours == -1):.1f} % visible"
                )


def main() -> None:
    """Print the figures."""
    for name in WORLDS:
        world = load_checked(name)
        (person,) = world.people
        place = Workstation.of(world, person)
        print_postures(name, place)
        print_room(name, world)
        print_too_far(name, place, person.figure)
        print_rays(name, world)
        for study in studies(world):
            for reach in study.reaches:
                leaning = math.ceil(1000 * reach.leaning)
                print(f"{name}, {reach.target}: short by {math.ceil(1000 * reach.short)} mm, leaning {leaning} mm")


if __name__ == "__main__":
    main()
