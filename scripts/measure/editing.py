"""Measure how long the studio takes to answer while a world is edited: processor time of the whole server, medians.

.venv/bin/python scripts/measure/editing.py
"""

import json
import math
import statistics
import tempfile
import time
from importlib import resources
from pathlib import Path

import httpx

from mjsim.bench.entering import client_of
from mjsim.web import Studio

RUNS = 7
ROBOT = "robots: [{name: scout, preset: pioneer3dx, at: [1, 1], sensors: [{camera: front}]}]\n"


def many_walls(count: int) -> str:
    """Return a world of so many walls that stand alone, a comment beside each."""
    lines = [
        f"  - {{points: [[{k % 40}, {k // 40 * 2}], [{k % 40 + 0.8}, {k // 40 * 2}]], height: 2.2}}   # wall {k}\n"
        for k in range(count)
    ]
    return f"mjsim: 1\nwalls:\n{''.join(lines)}{ROBOT}"


def long_wall(count: int) -> str:
    """Return a world with one wall of so many segments, which goes round."""
    turn = 2 * math.pi / count
    points = ", ".join(f"[{20 * math.cos(k * turn):.3f}, {20 * math.sin(k * turn):.3f}]" for k in range(count))
    return f"mjsim: 1\nwalls:\n  - closed: true\n    points: [{points}]\n{ROBOT}"


def main() -> None:
    """Print the table."""
    gallery = (resources.files("mjsim.worlds") / "gallery.yaml").read_text(encoding="utf-8")
    office = (resources.files("mjsim.worlds") / "office.yaml").read_text(encoding="utf-8")
    worlds = {"gallery": gallery, "office": office, "1000 walls": many_walls(1000), "1000 segments": long_wall(1000)}
    print(f"{'':15} {'text':>5} {'open':>6} {'parse':>6} {'edit':>6} {'answer':>7} {'first picture':>14} {'next':>6}")
    print(f"{'':15} {'KB':>5} {'ms':>6} {'ms':>6} {'ms':>6} {'KB':>7} {'ms':>14} {'ms':>6}")
    with tempfile.TemporaryDirectory() as folder:
        for name, text in worlds.items():
            (Path(folder) / f"{name}.yaml").write_text(text)
        with Studio(folder) as page, client_of(page.url) as client:
            for name, text in worlds.items():
                print(row(client, name, text), flush=True)


def row(client: httpx.Client, name: str, text: str) -> str:
    """Return what was measured with one world."""
    path = f"{name}.yaml"
    change = {"op": "set", "path": ["walls", 0, "thickness"], "value": 0.21}
    asks: dict[str, dict[str, object]] = {
        "open": {"path": path},
        "parse": {"path": path, "text": text},
        "edit": {"path": path, "text": text, "changes": [change]},
    }
    times: dict[str, list[float]] = {address: [] for address in asks}
    for _ in range(RUNS):
        for address, keys in asks.items():
            began = time.process_time()
            answer = client.post(f"/api/{address}", json=keys)
            times[address].append(1e3 * (time.process_time() - began))
            assert answer.status_code == 200, answer.text
    opened, parsed, edited = (statistics.median(found) for found in times.values())
    robot = next(item for item in answer.json()["items"] if item["kind"] == "robot")
    look = {"path": path, "text": text, "robot": robot["name"], "camera": "front", "heading_deg": 0}
    pictures = [seen(client, {**look, "at": [robot["at"][0] + 0.01 * k, robot["at"][1]]}) for k in range(RUNS + 1)]
    size = len(json.dumps(answer.json())) / 1e3
    figures = f"{opened:6.0f} {parsed:6.0f} {edited:6.0f} {size:7.0f}"
    return f"{name:15} {len(text) / 1e3:5.0f} {figures} {pictures[0]:14.0f} {statistics.median(pictures[1:]):6.1f}"


def seen(client: httpx.Client, look: dict[str, object]) -> float:
    """Return the processor time of one picture [ms]."""
    began = time.process_time()
    assert client.post("/api/preview", json=look).status_code == 200
    return 1e3 * (time.process_time() - began)


if __name__ == "__main__":
    main()
