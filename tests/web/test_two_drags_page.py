"""Things are dragged again before the server has answered the first time, in a real browser with a slow network."""

import pytest

pytestmark = pytest.mark.slow
OWN_WINDOW = True
ROOM = """
mjsim: 1
walls: [{points: [[0, 0], [8, 0], [8, 8], [0, 8]], closed: true}]
obstacles: [{name: post, box: [1, 1, 1], at: [2, 2]}]
"""
LATE = 1500
"""So late each answer comes [ms]."""


def test_a_second_drag_takes_what_the_first_one_has_just_put_down(sheet):
    network = sheet.page.context.new_cdp_session(sheet.page)
    network.send("Network.enable")
    slow = {"offline": False, "latency": LATE, "downloadThroughput": -1, "uploadThroughput": -1}
    network.send("Network.emulateNetworkConditions", slow)
    sheet.drag((2, 2), (4, 2))
    sheet.drag((4, 2), (4, 5))
    sheet.reads("at: [4, 5]")
    sheet.press("Control+z")
    sheet.reads("at: [4, 2]")
