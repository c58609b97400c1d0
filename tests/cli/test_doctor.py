import cv2
import pytest

from mjsim.doctor import diagnose, report_lines


@pytest.mark.slow
def test_the_doctor_draws_a_room_and_names_what_it_tried(tmp_path):
    diagnosis = diagnose(tmp_path / "new" / "room.png")
    assert diagnosis.backends[diagnosis.backend] == f"works: {diagnosis.renderer}"
    assert diagnosis.fault is None
    assert diagnosis.pictures_per_second > 5  # a 640 x 480 room on one slow core
    picture = cv2.imread(str(diagnosis.picture))
    assert picture.shape == (480, 640, 3)
    hue = cv2.cvtColor(picture, cv2.COLOR_BGR2HSV)[..., 0][cv2.cvtColor(picture, cv2.COLOR_BGR2HSV)[..., 1] > 150]
    for wanted in (0, 23, 107):  # the red box, the yellow cylinder and the blue box, in OpenCV's half degrees
        assert (abs(hue.astype(int) - wanted) < 4).mean() > 0.02
    lines = report_lines(diagnosis)
    assert lines[0] == f"backend   {diagnosis.backend}"
    assert any(diagnosis.versions["mujoco"] in line for line in lines)
