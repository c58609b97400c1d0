"""Reads hostile recordings one by one, and uses them as people would."""

import json
import shutil
import time
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path

import mjsim
from mjsim.algorithms.ekf_slam.ekf_slam import EkfSlam
from mjsim.bench.large import peak_memory
from mjsim.errors import MjsimError
from mjsim.record import export_csv, export_images, export_mat, export_npz, export_tum
from mjsim.report import key_table, statistics_file, write_report
from mjsim.report.labels import settings_of
from mjsim.video import make_video
from mjsim.web.review.reviewing import events_json, recording_json, row_json

LIMIT = 5.0
"""Maximum processor time of an input [s]."""
MEMORY = 1536
"""Maximum memory of an input, including this program [MB]."""
WORLD = """mjsim: 1
name: everything
walls: [{points: [[0, 0], [6, 0], [6, 4], [0, 4]], closed: true, openings: [{name: gate, segment: 0, at: 2, width: 0.9,
  door: {}}]}]
obstacles: [{name: box, box: [0.3, 0.3, 0.3], at: [4, 3], movable: true, mass: 2}]
beacons: [{name: lion, at: [5.9, 2], heading_deg: 180}, {name: owl, at: [0.1, 3]}]
robots:
  - name: scout
    preset: pioneer3dx
    at: [1, 2]
    odometry: {noise: {distance: 0.02, turn: 0.02}}
    sensors:
      - {beacons: ring, range: [0.3, 8], fov_deg: 360, rate_hz: 25, noise: {range: 0.05, bearing_deg: 1}}
      - {lidar: scan, at: [0.1, 0, 0.3], beams: 9, fov_deg: 180, range: [0.05, 3], rate_hz: 12.5}
      - {imu: inertial, rate_hz: 50}
      - {camera: front, at: [0.1, 0, 0.4], width: 32, height: 24, rate_hz: 12.5, noise: 0}
  - {name: idle, preset: pioneer3dx, at: [3, 3.3]}
run:
  map: known
  drivers:
    scout:
      estimator: {use: "mjsim.algorithms.ekf_slam:EkfSlam"}
      navigator: {use: "mjsim.algorithms.waypoints:Waypoints", points: [[5, 2]]}
  events: [{time: 0.1, move: box, to: [3, 3]}, {time: 0.2, light: 0.4}, {time: 0.2, open: gate}]
"""


class RecordingTrial:
    """Reads inputs one after the other, and remembers the slowest."""

    def __init__(self, folder: Path) -> None:
        self.count, self.read_well, self.slowest, self.last = 0, 0, 0.0, b""
        self._folder = folder
        self.file = folder / "run.mcap"

    def read(self, data: bytes) -> None:
        """Read an input, and look at it when it is a recording.

        Raises:
            TimeoutError: It took too long.
            MemoryError: It took too much memory.
        """
        self.count, self.last = self.count + 1, data
        self.file.write_bytes(data)
        start = time.process_time()
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            run: list[mjsim.Recording] = []
            self._told(lambda: run.append(mjsim.read_recording(self.file)))
            if run:
                self.read_well += 1
                for look in self._looks(run[0]):
                    self._told(look)
        taken = time.process_time() - start
        self.slowest = max(self.slowest, taken)
        if taken > LIMIT:
            raise TimeoutError(f"reading took {taken:.1f} s")
        if (needed := peak_memory()) > MEMORY:
            raise MemoryError(f"{needed:.0f} MB were needed")

    def _looks(self, run: mjsim.Recording) -> Iterator[Callable[[], object]]:
        """Yield the actions on a recording, expensive ones only now and then."""
        out = self._folder / "out"
        shutil.rmtree(out, ignore_errors=True)
        yield lambda: key_table(statistics_file(run))
        yield lambda: settings_of(run.world, run.metadata)
        yield lambda: json.dumps(recording_json(run, path="run.mcap", scene={}), allow_nan=False)
        yield lambda: json.dumps([row_json(run, row) for row in {0, len(run.time) - 1}], allow_nan=False)
        yield lambda: events_json(run)
        for name in run.robots:
            yield lambda name=name: list(run.observations(name))
            yield lambda name=name: list(run.joint_covariances(name))
        yield from self._kept(run, out)
        for every, look in (
            (200, lambda: mjsim.replay(run, robot="scout", estimator=EkfSlam())),
            (1000, lambda: write_report(run, out / "report")),
            (2000, lambda: make_video(run, out / "film.mp4", end=float(run.time[0]) + 0.1)),
        ):
            if self.count % every == 0:
                yield look

    def _kept(self, run: mjsim.Recording, out: Path) -> Iterator[Callable[[], object]]:
        """Yield exports of one kind, each kind in its turn."""
        kinds = (
            (export_tum, "t"),
            (export_csv, "c"),
            (export_npz, "a.npz"),
            (export_mat, "a.mat"),
            (export_images, "i"),
        )
        write, place = kinds[self.count % len(kinds)]
        yield lambda: write(run, out / place)
        if write is export_images:
            for robot, camera in run.cameras():
                yield lambda robot=robot, camera=camera: list(run.images(robot, camera))
        yield lambda: self._check_inside(out)

    def _check_inside(self, out: Path) -> None:
        strange = {path.name for path in self._folder.iterdir()} - {"out", "run.mcap"}
        assert not strange, f"{strange} lies beside the exports"
        assert all(path.is_relative_to(out) for path in out.rglob("*"))

    def _told(self, what: Callable[[], object]) -> None:
        """Perform an action that may fail with a one-line message."""
        try:
            what()
        except MjsimError as error:
            said = str(error)
            if not said or not said.isprintable():
                raise AssertionError(f"this is not a line for a person: {said!r}") from error


def seeds(folder: Path) -> list[bytes]:
    """Return small recordings: one with every kind of sensor, and its replay."""
    file, again = folder / "seed.mcap", folder / "again.mcap"
    with mjsim.Simulation(mjsim.parse_world(WORLD)) as sim:
        run = mjsim.run(sim, seconds=0.28, record=file)
    mjsim.replay(run, robot="scout", estimator=EkfSlam(), record=again)
    return [file.read_bytes(), again.read_bytes()]
