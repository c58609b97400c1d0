"""How well pictures are recognised in many drawn views: found, right, how exactly, how surely, how quickly.

    python tests/bench/vision_views.py [VIEWS]

Twelve pictures of 0.6 m are searched for, in a room with four more, at 640 x 480 with a field of view of 60 degrees.
"""

import sys
import time
from pathlib import Path

import cv2
import numpy as np

sys.path.insert(0, str(Path(__file__).parent.parent))
from test_beacon_vision import INTRINSICS, KNOWN, PICTURES, WIDTH, Studio, distance_squared, polar

from mjsim.algorithms.beacon_vision import PictureBeacons


def main(views: int) -> None:
    """Draw views, look at them, and print a table."""
    cv2.setNumThreads(1)
    studio, rng = Studio(), np.random.default_rng(2026)
    beacons = PictureBeacons({name: (PICTURES[name], WIDTH) for name in KNOWN})
    rows, seconds, gross = [], [], 0
    for k in range(views):
        name, distance, yaw = KNOWN[k % len(KNOWN)], float(rng.uniform(1.0, 5.5)), float(rng.uniform(-60.0, 60.0))
        shot = studio.before(name, distance, yaw, aside_deg=float(rng.uniform(-20, 20)), rng=rng if k % 2 else None)
        start = time.process_time()
        found = {each.name: each for each in beacons.detect(shot.image, INTRINSICS)}
        seconds.append(time.process_time() - start)
        for each in found.values():
            (far, bearing), (truth, direction) = polar(each.position), polar(shot.positions[each.name])
            gross += (
                shot.positions[each.name][2] < 0.0 or abs(far / truth - 1.0) > 0.1 or abs(bearing - direction) > 2.0
            )
        if name not in shot.whole:
            continue
        row = [distance, abs(yaw), float(name in found), np.nan, np.nan, np.nan]
        if name in found:
            (far, bearing), (truth, direction) = polar(found[name].position), polar(shot.positions[name])
            nees = distance_squared(found[name], shot.positions[name])
            row[3:] = [100.0 * abs(far / truth - 1.0), abs(bearing - direction), nees]
        rows.append(row)
    table = np.array(rows)
    cold, nees = 1e3 * np.mean(seconds), np.nanmean(table[:, 5])
    lines = [
        f"{views} views, {gross} wrong or gross, NEES {nees:.2f}, {cold:.1f} ms cold",
        "  m     deg    views  found   range error %   bearing error deg   NEES",
    ]
    for near, far in ((1.0, 1.5), (1.5, 2.5), (2.5, 3.5), (3.5, 4.5), (4.5, 5.5)):
        for low, high in ((0, 30), (30, 45), (45, 60)):
            part = table[(table[:, 0] >= near) & (table[:, 0] < far) & (table[:, 1] >= low) & (table[:, 1] < high)]
            if part[:, 2].any():
                error, bearing = np.nanmedian(part[:, 3]), np.nanmedian(part[:, 4])
                lines.append(
                    f"{near}-{far}  {low:2}-{high}  {len(part):5}  {part[:, 2].mean():.3f}  {error:13.3f}"
                    f"  {bearing:18.4f}  {np.nanmean(part[:, 5]):5.2f}"
                )
    sys.stdout.write("\n".join(lines) + "\n")
    studio.canvas.close()


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 2000)
