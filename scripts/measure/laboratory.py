"""Print the laboratory's figures beside what is asked of them: linear plants, and the numbers of python-control.

python scripts/measure/laboratory.py
"""

from collections.abc import Iterator

import control
import numpy as np

import mjsim
from mjsim.algorithms.balance import plant as balancing_plant
from mjsim.geometry import Array
from mjsim.interface import BalancingInfo
from mjsim.lab import LinearPlant, ScenePlant, study

G = 9.81
STEPS = (1, 4)
"""Of the physics [ms]."""
WORLD = """
mjsim: 1
robots:
  - {name: joe, preset: balancer, at: [0, 0]}
  - {name: scout, preset: pioneer3dx, at: [3, 0]}
mechanisms:
  - name: cart
    at: [6, 0]
    elevation: 2
    bodies: [{name: trolley, box: [0.3, 0.2, 0.1], mass: 1}, {name: pole, mass: 0.2, rod: [1.0, 0.03]}]
    joints:
      - {prismatic: x, of: [ground, trolley], axis: [1, 0, 0]}
      - {revolute: q, of: [trolley, pole], axis: [0, 1, 0], start_deg: -90}
plants:
  - {name: cart-pole, of: cart, input: x, outputs: [x, q], around: {q_deg: -90}}
  - {name: motor, of: scout, input: forward, outputs: way.rate}
  - {name: balancer, of: joe, input: torque, outputs: [way, lean]}
run: {step_ms: STEP}
"""


def main() -> None:
    """Print one line a figure: plant, step, figure, what is asked, what was found."""
    print(f"{'plant':<10} {'step':>5}  {'figure':<44} {'asked':>8}  found")
    for step in STEPS:
        world = mjsim.parse_world(WORLD.replace("STEP", str(step)))
        for plant in world.plants:
            scene = ScenePlant(world, plant)
            for what, asked, found in compared(scene, theory_of(scene)):
                fine = "" if found <= asked else "  NOT MET"
                print(f"{plant.name:<10} {step:>2} ms  {what:<44} {asked:8.0e}  {found:.1e}{fine}")


def theory_of(scene: ScenePlant) -> tuple[Array, Array]:
    """Return A and B of the books."""
    name = scene.plant.name
    return {"cart-pole": cart_pole, "motor": motor, "balancer": balancer}[name](scene)


def cart_pole(scene: ScenePlant) -> tuple[Array, Array]:
    """Return the upright pole on a cart, as in Ogata, Modern Control Engineering (5th ed., 2010), section 3.6."""
    body = scene.model.body("cart/pole")
    m, half, cart = float(body.mass[0]), 0.5, 1.0
    inertia = float(np.median(body.inertia)) + m * half**2
    det = (cart + m) * inertia - (m * half) ** 2
    A = np.zeros((4, 4))
    A[0, 2] = A[1, 3] = 1.0
    A[2, 1], A[3, 1] = -((m * half) ** 2) * G / det, m * G * half * (cart + m) / det
    return A, np.array([[0.0], [0.0], [inertia / det], [-m * half / det]])


def motor(scene: ScenePlant) -> tuple[Array, Array]:
    """Return one lag: two servos that push with torque in proportion to the speed that is missing."""
    model, radius = scene.model, 0.0975
    wheel, servo = model.body("scout/wheel_left"), model.actuator("scout/wheel_left")
    turning = wheel.inertia[1] + model.dof_armature[model.joint("scout/wheel_left").dofadr[0]]
    mass = model.body("scout/base").mass[0] + 2 * wheel.mass[0] + 2 * turning / radius**2
    pole = float(-2 * servo.gainprm[0] / radius**2 / mass)
    return np.array([[pole]]), np.array([[-pole]])


def balancer(scene: ScenePlant) -> tuple[Array, Array]:
    """Return Pathak et al., Velocity and Position Control of a Wheeled Inverted Pendulum, T-RO 21 (2005)."""
    m, r, width, box = 1.0, 0.105, 0.02625, (0.16, 0.32, 0.55)
    masses = BalancingInfo(
        wheel_mass=m,
        wheel_inertia=m * r**2 / 2,
        wheel_across=m * (r**2 / 4 + width**2 / 3),
        body_mass=12.0,
        center=0.30,
        pitch_inertia=box[0] ** 2 + box[2] ** 2,
        yaw_inertia=box[0] ** 2 + box[1] ** 2,
        max_torque=4.0,
    )
    return balancing_plant(masses, wheel_radius=r)


def compared(scene: ScenePlant, theory: tuple[Array, Array]) -> Iterator[tuple[str, float, float]]:
    """Yield figures: what, what is asked, and what was found."""
    A, B = theory
    plant = scene.linear
    yield "A, largest difference", 1e-5, float(np.abs(plant.A - A).max())
    yield "B, largest difference", 1e-5, float(np.abs(plant.B - B).max())
    ours, theirs = (np.sort_complex(np.linalg.eigvals(each)) for each in (plant.A, A))
    moving = np.abs(theirs) > 1e-6
    off = np.abs(ours[moving] - theirs[moving]) / np.abs(theirs[moving])
    yield "poles, largest relative difference", 5e-4, float(off.max())
    yield from against_control(plant)


def against_control(plant: LinearPlant) -> Iterator[tuple[str, float, float]]:
    """Yield how far the page is from python-control for the same matrices, relative to the largest value."""
    found, system = study(plant), control.ss(plant.A, plant.B, plant.C, plant.D)
    for name, values, response in (
        ("step", found.step, control.step_response(system, found.time, squeeze=False)),
        ("impulse", found.impulse, control.impulse_response(system, found.time, squeeze=False)),
    ):
        expected = response.outputs[:, 0, :]
        yield f"{name} response, against python-control", 1e-9, _off(values, expected)
    loop = control.ss(plant.A, plant.B, plant.C[:1], plant.D[:1])
    expected = loop(1j * found.omega)
    yield "frequency response, against python-control", 1e-9, _off(found.magnitude * np.exp(1j * found.phase), expected)
    gain, phase, *_ = control.margin(loop)
    pairs = [(found.margins["gain_margin"], gain), (found.margins["phase_margin_deg"], phase)]
    off = [abs(ours - theirs) for ours, theirs in pairs if ours is not None]
    yield "margins, against python-control", 1e-9, float(max(off, default=0.0))


def _off(found: Array, expected: Array) -> float:
    return float(np.abs(found - expected).max() / np.abs(expected).max())


if __name__ == "__main__":
    main()
