"""What is measured: each figure gets ready once, then gives one value a run."""

from mjsim.bench.baked import baked_against, furnished, textured_gallery
from mjsim.bench.figure import Figure
from mjsim.bench.filters import FILTER_FIGURES
from mjsim.bench.large import large
from mjsim.bench.loops import (
    computed_torque,
    encoding_alone,
    loop_speed,
    modules_alone,
    physics_alone,
    rendering_alone,
    whole_run,
    whole_tick,
)
from mjsim.bench.pictures import (
    gallery_sensed,
    office_geom_by_geom,
    office_sensed,
    picture_floor,
    pictures,
    stock,
    stock_compiled,
)
from mjsim.bench.recordings import film, recording
from mjsim.bench.scenes import LIDAR, hall
from mjsim.bench.sensing import SENSOR_FIGURES

PLAIN = "times a plain picture"
PACE, PICTURES, TICK = "simulated seconds a second", "pictures a second", "ms a tick, processor"
LARGE = (1000, 3000, 10_000)
"""Wall segments."""
OFFICE = 2000
"""Wall segments of the office."""
FIGURES = (
    Figure("loop", PACE, loop_speed(hall, seconds=4.0)),
    Figure("loop-lidar", PACE, loop_speed(lambda: hall(LIDAR), seconds=4.0)),
    Figure("loop-lidar-25", PACE, loop_speed(lambda: hall(LIDAR.replace("12.5", "25")), seconds=4.0, turn=0.3)),
    Figure("loop-8-lidars", PACE, loop_speed(lambda: hall(LIDAR, robots=8), seconds=2.0)),
    Figure("loop-camera", PACE, loop_speed(lambda: hall("{camera: front, noise: 0}"), seconds=2.0)),
    Figure("arm-computed-torque", PACE, computed_torque),
    Figure("gallery", PACE, whole_run),
    Figure("tick-gallery", TICK, whole_tick),
    Figure("tick-physics", TICK, physics_alone),
    Figure("tick-rendering", TICK, rendering_alone),
    Figure("tick-modules", TICK, modules_alone),
    Figure("tick-encoding", TICK, encoding_alone),
    Figure("pictures-640x480", PICTURES, pictures),
    Figure("pictures-floor", PICTURES, picture_floor(640, 480)),
    Figure("sense-640x480", PICTURES, gallery_sensed(640, 480)),
    Figure("stock-640x480", PICTURES, stock(640, 480)),
    Figure("stock-compiled", PICTURES, stock_compiled),
    Figure("floor-320x240", PICTURES, picture_floor(320, 240)),
    Figure("sense-320x240", PICTURES, gallery_sensed(320, 240)),
    Figure("stock-320x240", PICTURES, stock(320, 240)),
    Figure("sense-high", PICTURES, gallery_sensed(640, 480, places=8, quality="high")),
    Figure("baked", PLAIN, baked_against("normal")),
    Figure("baked-textured", PLAIN, baked_against("normal", make=textured_gallery)),
    Figure("furnished", "times one of the textured gallery", furnished),
    Figure("baked-high", "times plain in high quality", baked_against("high", baked="high")),
    Figure("office", PICTURES, office_sensed(OFFICE)),
    Figure("office-geoms", PICTURES, office_geom_by_geom(OFFICE)),
    *SENSOR_FIGURES,
    *FILTER_FIGURES,
    Figure("recording", "ticks a second", recording(pictures=True)),
    Figure("recording-numbers", "ticks a second", recording(pictures=False)),
    Figure("film", "frames a second", film),
    *(Figure(f"large-{n}", "s to be made ready", large(n, memory=False)) for n in LARGE),
    *(Figure(f"large-{n}-memory", "MB at most", large(n, memory=True)) for n in LARGE),
)
"""In the order in which they are printed."""
