"""An arm is moved by hand: from Python, over the WebSocket, and by sliders in a real browser."""

import math
from contextlib import contextmanager

import numpy as np
import pytest

import mjsim
from mjsim.errors import UsageError
from mjsim.mechanics import rpy_of
from mjsim.session import Session
from mjsim.web import LiveView
from mjsim.world import arm_world
from tests.browser import browser as listener

PATH = 'navigator: {use: "mjsim.algorithms.joint_path:JointPath", to_deg: [20, 0, 0, 0, 0, 0], seconds: 1}'
DRIVEN = (
    "mjsim: 1\nrobots: [{name: r, base: fixed, at: [1, 2], heading_deg: 90, arms: [{preset: puma560}]}]\n"
    f"run: {{seconds: 1000, drivers: {{r: {{{PATH}}}}}}}\n"
)


@contextmanager
def moving(world, **keys):
    """A session of a world that runs as fast as it goes, and its page."""
    with LiveView(world) as page:
        session = Session(world, on_tick=page.show, on_change=page.changed, **keys)
        page.steer(session)
        with session:
            yield session, page


def at_rest(session, arm="r/arm", *, near):
    """Wait until the joints of an arm are where they should be, and return how they move."""
    watcher = session.watch()
    for _ in range(2000):
        motion = watcher.next().joints[arm]
        if np.abs(motion.positions - near).max() < 0.02 and np.abs(motion.velocities).max() < 0.01:
            return motion
    raise AssertionError(f"the joints are at {motion.positions}, not at {near}")


def settled(session, arm, field):
    """Wait until a field of the page shows the height of the tool, and return it: the page is a few pictures behind."""
    watcher = session.watch()
    for _ in range(2000):
        there, shown = watcher.next().joints[arm].tool[2, 3], float(field.input_value())
        if abs(shown - there) < 0.002:
            return shown
    raise AssertionError(f"the page says {shown}, the arm {there}")


@pytest.mark.slow
def test_joints_go_where_a_hand_wants_them_and_back_to_the_navigator():
    with moving(mjsim.parse_world(DRIVEN)) as (session, _):
        at_rest(session, near=[math.radians(20), 0, 0, 0, 0, 0])
        session.move_joints("r", "arm", [0.5, 0.2, -0.3, 0.1, 0.2, 0.3])
        at_rest(session, near=[0.5, 0.2, -0.3, 0.1, 0.2, 0.3])
        session.move_joints("r", "arm", None)
        at_rest(session, near=[math.radians(20), 0, 0, 0, 0, 0])


@pytest.mark.slow
def test_a_hand_moves_joints_no_faster_than_a_radian_a_second():
    with moving(mjsim.parse_world(DRIVEN.replace(PATH, "avoidance: true"))) as (session, _):
        session.pause()
        session.move_joints("r", "arm", [1.0, 0, 0, 0, 0, 0])
        fastest = 0.0
        for _ in range(40):
            number = session.newest.time if session.newest else -1.0
            session.tick()
            session.wait("paused")
            while session.newest is None or session.newest.time <= number:
                session.wait("paused", timeout=0.01)
            fastest = max(fastest, abs(float(session.newest.joints["r/arm"].velocities[0])))
        assert 0.8 < fastest < 1.2


@pytest.mark.slow
def test_the_tool_goes_to_a_pose_in_the_frame_of_the_robot():
    with moving(mjsim.parse_world(DRIVEN)) as (session, _):
        at_rest(session, near=[math.radians(20), 0, 0, 0, 0, 0])
        arm, q = session.world.robots[0].arms[0].arm, [0.3, 0.5, -0.8, 0.2, 0.4, 0.1]
        goal = arm.fkine(q)
        session.move_tool("r", "arm", at=goal[:3, 3], rpy=rpy_of(goal))
        watcher = session.watch()
        tools = (arm.fkine(watcher.next().joints["r/arm"].positions) for _ in range(1000))
        assert any(np.abs(tool - goal).max() < 0.01 for tool in tools)


WRONG = {
    "robot 'r' has no arm 'amr'; did you mean 'arm'?": ("r", "amr", [0.0] * 6),
    "no robot 's' in this world; there are r": ("s", "arm", [0.0] * 6),
    "arm 'arm' has 6 joints; give as many finite numbers": ("r", "arm", [0.0] * 5),
    "joint 1 of arm 'arm' cannot go to 515.662; its range is -160 to 160": ("r", "arm", [9.0, 0, 0, 0, 0, 0]),
}


@pytest.mark.slow
@pytest.mark.parametrize(("said", "asked"), WRONG.items())
def test_what_an_arm_cannot_do_is_refused_in_one_line(said, asked):
    with Session(mjsim.parse_world(DRIVEN)) as session:
        session.pause()
        with pytest.raises(UsageError) as caught:
            session.move_joints(*asked)
        assert str(caught.value) == said
        with pytest.raises(UsageError, match=r"the tool of 'arm' does not reach 5, 0, 0 m turned so; it misses by"):
            session.move_tool("r", "arm", at=[5, 0, 0], rpy=[0, 0, 0])
        assert session.touched == ()


@pytest.mark.slow
def test_a_browser_receives_arms_and_moves_them():
    with moving(mjsim.parse_world(DRIVEN)) as (_, page), listener(page.url) as browser:
        run = browser.until("run", state="running")
        (arm,) = run["robots"][0]["arms"]
        assert [joint["name"] for joint in arm["joints"]] == [f"joint{k}" for k in range(1, 7)]
        assert arm["joints"][0]["upper"] == pytest.approx(math.radians(160))
        browser.say("touch", event={"reach": "r", "joints_deg": [math.degrees(0.4), 0, 0, 0, 0, 0]})
        while abs(browser.until("tick")["robots"]["r"]["arms"]["arm"]["positions"][0] - 0.4) > 0.02:
            pass
        browser.say("touch", event={"reach": "r", "tool": [9, 9, 9]})
        short = browser.until("short")
        assert (short["of"], short["part"]) == ("r", "arm")
        assert 12 < short["metres"] < 9 * math.sqrt(3)  # an arm of less than 2 m, from its robot
        browser.say("touch", event={"reach": "r", "joints_deg": [1, 2]})
        assert "has 6 joints" in browser.until("refused", do="touch")["error"]


@pytest.mark.parametrize("name", ["puma560", "motoman_up6"])
def test_an_arm_alone_is_a_world(name):
    world = arm_world(name)
    assert (world.name, world.robots[0].arms[0].arm.n) == (name, 6)


def test_an_arm_of_a_file_is_a_world(tmp_path):
    path = tmp_path / "two.yaml"
    path.write_text("dh:\n  rows: [{a: 0.3}, {slide: true, range: [0, 0.5], alpha_deg: 90}]\ntool: {at: [0, 0, 0.1]}\n")
    assert arm_world(path).robots[0].arms[0].arm.links[1].slide


@pytest.mark.slow
def test_sliders_and_fields_move_an_arm_in_a_browser(browser):
    from playwright.sync_api import expect

    from tests.windows import PATIENCE, page_at

    world = arm_world("puma560")
    with LiveView(world) as live:
        session = Session(world, speed=1.0, on_tick=live.show, on_change=live.changed)
        live.steer(session)
        with session, page_at(browser, live.url, outside=True) as page:
            expect(page.get_by_role("tab", name="Joints")).to_have_attribute("aria-selected", "true", timeout=PATIENCE)
            page.locator("[data-view='outside'] canvas[data-filled]").wait_for(timeout=PATIENCE)
            slider = page.get_by_role("slider", name="joint1")
            expect(slider).to_be_enabled(timeout=PATIENCE)
            expect(page.get_by_label("arm tool x")).not_to_have_value("", timeout=PATIENCE)
            slider.fill("0.5")
            slider.blur()
            at_rest(session, "robot/arm", near=[0.5, 0, 0, 0, 0, 0])
            page.get_by_label("joint3, °").fill("-30")
            page.get_by_label("joint3, °").press("Enter")
            page.get_by_label("joint3, °").blur()
            at_rest(session, "robot/arm", near=[0.5, 0, -math.pi / 6, 0, 0, 0])
            field = page.get_by_label("arm tool z")
            higher = settled(session, "robot/arm", field) + 0.1
            field.fill(f"{higher}")
            field.press("Enter")
            field.blur()
            watcher = session.watch()
            assert any(abs(watcher.next().joints["robot/arm"].tool[2, 3] - higher) < 0.01 for _ in range(500))
            page.get_by_label("arm tool x").fill("7")
            page.get_by_label("arm tool x").press("Enter")
            expect(page.get_by_text("The tool of arm of robot cannot reach that point")).to_be_visible(timeout=PATIENCE)
