"""What an estimator believes has a body in the 3-D view, in a real browser, seen by a camera that looks at it level."""

import math

import cv2
import numpy as np
import pytest
from playwright.sync_api import expect

import mjsim
from mjsim.web import Studio
from tests.sheet import DRAWN
from tests.windows import PATIENCE, page_at

pytestmark = pytest.mark.slow
FAR, HIGH, FOV_DEG = 5.0, 0.6, 60.0
WORLD = f"""
robots:
  - {{name: scout, at: [0, 0], body: {{radius: 0.1, height: 0.1, mass: 5}}}}
  - {{name: runner, at: [{-FAR - 1}, 1], body: {{radius: 0.1, height: 0.1, mass: 5}}}}
  - {{name: watcher, at: [{-FAR}, 0], 
     sensors: [{{camera: eye, at: [0, 0, {HIGH}], width: 64, height: 64, fov_deg: {FOV_DEG}, rate_hz: 5}}]}}
run: {{rate_hz: 25}}
"""
SIGMA = np.array([0.1, 0.2, 0.3])
"""Of x, y [m] and heading [rad]."""
LANDMARK, SPREAD = (1.0, 1.5), 0.1


class Sure:
    """Stands still, and is as sure of its place and of one landmark as it is told."""

    def __init__(self, landmarks: dict):
        self.landmarks = landmarks

    def start(self, robot, catalogue, rng):
        self.prior = robot.prior

    def update(self, seen):
        return mjsim.Estimate(self.prior, np.diag(SIGMA**2), landmarks=self.landmarks)


class Ahead:
    """Drives ahead."""

    def start(self, robot, catalogue, rng):
        pass

    def command(self, seen, belief):
        return mjsim.Command(1.0, 0.0)


def recorded(path) -> float:
    """Record how the scout stands still and the runner passes below the eye; return how far before that it ends [m]."""
    landmarks = {"tag": (np.array(LANDMARK), SPREAD**2 * np.eye(2))}
    drivers = {
        "scout": mjsim.Driver(estimator=Sure(landmarks)),
        "runner": mjsim.Driver(estimator=Sure({}), navigator=Ahead()),
    }
    with mjsim.Simulation(mjsim.parse_world(WORLD)) as sim:
        mjsim.run(sim, drivers=drivers, seconds=4, record=path)
        return sim.truth("runner").x + FAR


def reviewed(page):
    """Open the recording, look at its end through the watcher's camera, and return the canvas of the view in 3-D."""
    page.get_by_role("tab", name="Review", exact=True).click()
    page.locator("[data-path='out/run.mcap']").click()
    expect(page.locator(".run-time")).to_contain_text("of 3.96 s", timeout=PATIENCE)
    page.get_by_title("View in 3-D").locator("visible=true").click()
    page.locator("#view-review [data-view=scene] .run-enlarge").click()
    page.get_by_label("Look from").locator("visible=true").select_option("watcher/eye")
    page.get_by_role("slider", name="Time").press("End")
    return page.locator(".scene-canvas").locator("visible=true")


def picture(canvas) -> np.ndarray:
    """Return the view in 3-D once all its pixels and its light are drawn, shape (h, w, 3)."""
    for name, value in (("share", "1.00"), ("shaded", "true")):
        expect(canvas).to_have_attribute(f"data-{name}", value, timeout=PATIENCE)
    canvas.page.evaluate(DRAWN)
    return cv2.imdecode(np.frombuffer(canvas.screenshot(), np.uint8), cv2.IMREAD_COLOR).astype(int)


def drawn_of(canvas, layer) -> np.ndarray:
    """Return where a layer, which is left away from here on, is drawn in the view, shape (h, w)."""
    page, before, frames = canvas.page, picture(canvas), canvas.get_attribute("data-frames")
    page.locator("[data-view=scene]").get_by_label("What is shown").first.click()
    page.get_by_role("checkbox", name=layer).uncheck()
    page.keyboard.press("Escape")
    expect(canvas).not_to_have_attribute("data-frames", frames, timeout=PATIENCE)
    return np.abs(picture(canvas) - before).sum(axis=2) > 20


def focal_of(drawn) -> float:
    """Return the focal length of a view [px]."""
    return drawn.shape[0] / 2 / math.tan(math.radians(FOV_DEG) / 2)


def a_pose_is_a_body_as_wide_as_its_ellipse_and_as_high_as_its_heading_is_unsure(drawn):
    focal = focal_of(drawn)
    drawn = drawn[:, drawn.shape[1] // 2 - int(0.15 * focal) :]  # without the landmark, which lies to the left
    rows, columns = np.flatnonzero(drawn.any(axis=1)), np.flatnonzero(drawn.any(axis=0))
    # The silhouette of an ellipsoid in perspective: seen from so far, it reaches d / sqrt(d^2 - a^2) farther.
    nearer = FAR / math.sqrt(FAR**2 - 5.991 * SIGMA[0] ** 2)
    wide = 2 * focal * math.sqrt(5.991) * SIGMA[1] / FAR * nearer
    high = 2 * focal * 1.96 * SIGMA[2] / FAR * nearer
    assert columns[-1] - columns[0] == pytest.approx(wide, abs=3)
    assert rows[-1] - rows[0] == pytest.approx(high, abs=6)
    # It is round: at its upper end it is narrower than in its middle.
    assert drawn[rows[0] + 4].sum() < 0.5 * drawn[(rows[0] + rows[-1]) // 2].sum()


def a_landmark_is_a_column_on_its_ellipse(drawn):
    focal = focal_of(drawn)
    middle = drawn.shape[1] / 2 - focal * LANDMARK[1] / (FAR + LANDMARK[0])
    reach = focal * math.sqrt(5.991) * SPREAD / (FAR + LANDMARK[0])
    column = drawn[:, int(middle - 2 * reach) : int(middle + 2 * reach)]
    rows, columns = np.flatnonzero(column.any(axis=1)), np.flatnonzero(column.any(axis=0))
    assert columns[-1] - columns[0] == pytest.approx(2 * reach, abs=4)
    # From the floor to half a metre; its nearer rim is seen lower, its farther one higher.
    near, far = FAR + LANDMARK[0] - math.sqrt(5.991) * SPREAD, FAR + LANDMARK[0] + math.sqrt(5.991) * SPREAD
    low, high = focal * HIGH / near, focal * (HIGH - 0.5) / far
    assert rows[-1] - rows[0] == pytest.approx(low - high, abs=4)


def a_path_that_passes_below_the_eye_is_a_line_so_wide_from_the_lower_rim_on(drawn, ends):
    focal, (height, width) = focal_of(drawn), drawn.shape
    rows = np.flatnonzero(drawn.any(axis=1))
    # It lies a metre to the left, a few centimetres above the floor, and begins a metre behind the eye.
    below = HIGH - 0.03
    assert rows[0] == pytest.approx(height / 2 + focal * below / ends, abs=6)
    assert rows[-1] >= height - 2
    middles = np.array([np.flatnonzero(drawn[row]).mean() for row in rows[5:-5]])
    np.testing.assert_allclose(middles, width / 2 - (rows[5:-5] + 0.5 - height / 2) / below, atol=4)
    # The path by its wheels, 2 px wide, lies under the true one: 4.5 px, measured across.
    across = drawn[rows[5:-5]].sum(axis=1) * math.cos(math.atan(1 / below))
    assert 3.5 < np.median(across) < 7


def test_beliefs_and_paths_have_the_shapes_that_a_level_camera_sees(browser, tmp_path):
    (tmp_path / "out").mkdir()
    ends = recorded(tmp_path / "out" / "run.mcap")
    with Studio(tmp_path) as studio, page_at(browser, studio.url) as page:
        canvas = reviewed(page)
        bodies, paths = drawn_of(canvas, "95 %"), drawn_of(canvas, "Trails")
    a_pose_is_a_body_as_wide_as_its_ellipse_and_as_high_as_its_heading_is_unsure(bodies)
    a_landmark_is_a_column_on_its_ellipse(bodies)
    a_path_that_passes_below_the_eye_is_a_line_so_wide_from_the_lower_rim_on(paths, ends)
