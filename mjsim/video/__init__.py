"""A recording -> film: plan and figures drawn, 3-D views drawn again from the recorded states."""

from mjsim.video.film import frame_rows, frames_between, make_video, require_film_name
from mjsim.video.sheet import draw_world
from mjsim.video.still import take_picture

__all__ = ["draw_world", "frame_rows", "frames_between", "make_video", "require_film_name", "take_picture"]
