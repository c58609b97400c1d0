"""Previews of cameras: of robots with a fixed base and beside them, and the newest one when several wait."""

import threading
import time

import cv2
import numpy as np
import pytest

import mjsim
from mjsim.geometry import Pose
from mjsim.video import take_picture
from mjsim.web.edit.preview import Preview, PreviewRequest
from mjsim.web.server.answers import RefusedError

pytestmark = pytest.mark.slow
PATIENCE = 60.0

WORLD = """\
mjsim: 1
walls: [{points: [[-3, -3], [3, -3], [3, 3], [-3, 3]], closed: true}]
beacons: [{name: lion, image: posters/lion.jpg, at: [2.94, 0], heading_deg: 180}]
robots:
  - {name: post, base: fixed, at: [0, 0], sensors: [{camera: eye, at: [0.2, 0, 1], width: 160, height: 120,
     noise: 0}]}
  - {name: scout, preset: pioneer3dx, at: [-1, 1], sensors: [{camera: front, at: [0.2, 0, 1], width: 160, height: 120,
     noise: 0}]}
"""


def pixels(jpeg):
    return cv2.imdecode(np.frombuffer(jpeg, np.uint8), cv2.IMREAD_COLOR).astype(int)


@pytest.mark.parametrize(("robot", "camera", "at"), [("post", "eye", "[0, 0]"), ("scout", "front", "[-1, 1]")])
def test_a_robot_with_a_fixed_base_is_seen_from_where_it_is_dragged_to(client, robot, camera, at):
    asked = {"path": "room.yaml", "text": WORLD, "robot": robot, "camera": camera, "width": 160, "heading_deg": 0}
    for place in ([1.0, 0.5], [-1.0, 0.0]):
        answer = client.post("/api/preview", json={**asked, "at": place})
        assert answer.status_code == 200, answer.text
        moved = mjsim.parse_world(WORLD.replace(f"at: {at}", f"at: {place}"))
        wanted = take_picture(moved, f"{robot}/{camera}")[..., ::-1]
        # JPEG alone; from the other place the mean differs by more than 4.
        assert np.abs(pixels(answer.content) - wanted.astype(int)).mean() < 2.0


def test_of_several_previews_that_wait_only_the_newest_is_drawn():
    world, preview = mjsim.parse_world(WORLD), Preview()
    results = {}

    def ask(number):
        look = PreviewRequest(world, "scout", "front", Pose(1.0 + 0.1 * number, 2.0, 0.0), 96)
        try:
            began = time.perf_counter()
            results[number], milliseconds = preview.picture(look)
            assert 1.0 < milliseconds <= 1e3 * (time.perf_counter() - began)
        except RefusedError as error:
            results[number] = error.more

    ask(0)
    hold, held = threading.Event(), threading.Event()
    # While something else is being drawn, others come.
    preview._pool.submit(lambda: (held.set(), hold.wait(PATIENCE)))
    held.wait(PATIENCE)
    threads = [threading.Thread(target=ask, args=[number]) for number in range(1, 6)]
    for number, thread in enumerate(threads, start=1):
        thread.start()
        while preview._newest <= number:
            pass
    hold.set()
    for thread in threads:
        thread.join(PATIENCE)
    preview.close()
    assert [results[k] for k in range(1, 5)] == [{"superseded": True}] * 4
    assert results[5] != results[0]
    assert results[5][:2] == b"\xff\xd8"
