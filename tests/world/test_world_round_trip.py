"""A world built of any values writes to a text that reads back equal."""

import pytest
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

from mjsim.world import (
    Beacon,
    BoxObstacle,
    Camera,
    CylinderObstacle,
    DifferentialDrive,
    Modules,
    Opening,
    Robot,
    Run,
    Use,
    Wall,
    World,
    format_world,
    parse_world,
)

# A failure is told as it was found: making a whole world smaller takes minutes.
BOUNDED = settings(
    deadline=None,
    phases=[Phase.explicit, Phase.reuse, Phase.generate],
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large],
)

lengths = st.one_of(st.floats(1e-3, 1e4, allow_nan=False), st.integers(1, 100).map(float))
metres = st.one_of(st.floats(-1e4, 1e4, allow_nan=False), st.integers(-100, 100).map(float))
degrees = st.floats(-3600, 3600)
points = st.tuples(metres, metres)
colors = st.from_regex(r"\A#[0-9a-f]{6}\Z")
names = st.one_of(
    st.from_regex(r"\A[A-Za-z0-9_][A-Za-z0-9_.-]{0,12}\Z"),
    st.sampled_from(
        ["no", "yes", "null", "true", "1e3", "0x1F", "12", "1.5", "007", "2026-01-02", "_", "0o7", "1_000"]
    ),
)
texts = st.text(st.characters(codec="utf-8", categories=["L", "N", "P", "S", "Zs"]), max_size=20)
arguments = st.recursive(
    st.one_of(st.none(), st.booleans(), st.integers(-(10**9), 10**9), st.floats(-1e300, 1e300), texts, names),
    lambda inner: st.one_of(st.lists(inner, max_size=3), st.dictionaries(names, inner, max_size=3)),
    max_leaves=6,
)

openings = st.builds(
    Opening, at=st.floats(0, 100), width=lengths, sill=st.floats(0, 1), head=st.floats(1.5, 3), segment=st.just(0)
)
walls = st.builds(
    Wall,
    points=st.lists(points, min_size=2, max_size=5, unique=True).map(tuple),
    closed=st.booleans(),
    height=lengths,
    thickness=lengths,
    color=colors,
    openings=st.lists(openings, max_size=2).map(tuple),
)
boxes = st.builds(BoxObstacle, box=st.tuples(lengths, lengths, lengths), at=points, heading_deg=degrees)
cylinders = st.builds(CylinderObstacle, cylinder=st.tuples(lengths, lengths), at=points, color=colors)
beacons = st.builds(Beacon, name=st.just("b"), at=points, heading_deg=degrees, width=lengths)
cameras = st.builds(
    Camera,
    camera=st.just("c"),
    yaw_deg=degrees,
    width=st.integers(16, 4096),
    rate_hz=st.sampled_from([25.0, 12.5, 5.0]),
    noise=st.floats(0, 9),
)
drives = st.builds(DifferentialDrive, track=lengths, max_speed=st.floats(0.1, 20))
uses = st.tuples(arguments.filter(lambda value: value is not None), names.filter(lambda name: name != "use")).map(
    lambda pair: Use.model_validate({"use": "a.b:C", pair[1]: pair[0]})
)
modules = st.builds(Modules, navigator=uses, avoidance=st.one_of(st.booleans(), uses))


@st.composite
def worlds(draw):
    taken = iter(draw(st.lists(names, min_size=12, max_size=12, unique=True)))

    def named(strategy):
        return tuple(item.model_copy(update={"name": next(taken)}) for item in draw(st.lists(strategy, max_size=2)))

    robots = []
    for name in [next(taken) for _ in range(draw(st.integers(0, 2)))]:
        sensors = [
            camera.model_copy(update={"camera": f"c{index}"})
            for index, camera in enumerate(draw(st.lists(cameras, max_size=2)))
        ]
        keys = {"name": name, "at": draw(points), "sensors": tuple(sensors), "drive": draw(drives)}
        if draw(st.booleans()):
            keys |= {"preset": "pioneer3dx"}
            keys |= {"drive": {"track": 0.5}, "body": {"mass": draw(lengths)}}
        robots.append(Robot.model_validate(keys))
    return World(
        name=draw(names),
        walls=named(walls),
        obstacles=named(st.one_of(boxes, cylinders)),
        beacons=named(beacons),
        robots=tuple(robots),
        run=Run(seconds=draw(lengths), drivers={robot.name: draw(modules) for robot in robots}),
    )


@pytest.mark.slow
@settings(BOUNDED, max_examples=12)
@given(worlds())
def test_any_world_built_in_python_reads_back_equal_from_its_text(world):
    assert parse_world(format_world(world)) == world


@pytest.mark.slow
@settings(BOUNDED, max_examples=6)
@given(worlds(), worlds())
def test_any_change_of_a_world_that_was_read_is_written_back(before, after):
    read = parse_world(format_world(before))
    changed = read.model_copy(update={key: getattr(after, key) for key in World.model_fields})
    assert parse_world(format_world(changed)) == after
