#!/usr/bin/env python3
"""Measure the page of the studio in Chromium: how fast it draws and answers, what it loads, and the memory it takes.

    git worktree add ../before COMMIT && ../before/scripts/setup
    .venv/bin/python scripts/measure/page.py [CHECKOUT]... [--seconds 10] [--rounds 3]

Each checkout serves its own page of the gallery; they take turns. The run goes on at real time, watched by its camera.
Processor time is that of the browser alone, and of the server with the simulation; unlike the other rates it hardly
depends on other work of the machine. An answer is from the key of one tick to its time on the page. Memory is that of
scripts after a collection, and of the server at its peak. Numbers are medians over the rounds.
"""

import argparse
import gzip
import os
import statistics
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from playwright.sync_api import CDPSession, Page

from mjsim.bench.chromium import chromium, page_at

HERE = Path(__file__).resolve().parents[2]
FIRST_LOAD = ("index.html", "studio.js", "studio.css")
PATIENCE = 120_000
"""[ms]"""
TICKS = 20
MB = 1e6
FRAMES = """seconds => new Promise(done => {
  const [began, time] = [performance.now(), () => parseFloat(document.querySelector('.run-time').textContent)];
  const from = time();
  let frames = 0;
  const next = now => {
    frames += 1;
    if (now - began < 1000 * seconds) return requestAnimationFrame(next);
    const took = (now - began) / 1000;
    done([frames / took, (time() - from) / took]);
  };
  requestAnimationFrame(next);
})"""
ANSWERED = "before => document.querySelector('.run-time').textContent !== before"


def main() -> None:
    """Print a column for each checkout."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("checkouts", type=Path, nargs="*", default=[HERE])
    parser.add_argument("--seconds", type=float, default=10.0)
    parser.add_argument("--rounds", type=int, default=3)
    given = parser.parse_args()
    rounds = [[measured(each, given.seconds) for each in given.checkouts] for _ in range(given.rounds)]
    print(f"{'':44}", *(f"{each.resolve().name:>12}" for each in given.checkouts))
    for name in rounds[0][0]:
        medians = (statistics.median(row[k][name] for row in rounds) for k in range(len(given.checkouts)))
        print(f"{name:44}", *(f"{value:12.2f}" for value in medians))


def measured(checkout: Path, seconds: float) -> dict[str, float]:
    """Return the figures of one checkout by name."""
    remembers = {"mjsim.run.outside": "no"}
    with (
        served(checkout) as (server, url),
        chromium() as browser,
        page_at(browser, url, own=True, remembers=remembers) as page,
    ):
        page.set_default_timeout(PATIENCE)
        session = page.context.new_cdp_session(page)
        page.get_by_role("tab", name="Run", exact=True).click()
        page.get_by_role("button", name="Start", exact=True).click()
        page.locator("[data-view='scout/front'] canvas[data-filled]").wait_for()
        spent = browsers(), processor(server)
        frames, pace = page.evaluate(FRAMES, seconds)
        page_cpu, server_cpu = browsers() - spent[0], processor(server) - spent[1]
        simulated = pace * seconds
        return {
            "frames of the page a second": frames,
            "simulated seconds a second": pace,
            "processor time of the browser a simulated second [s]": page_cpu / simulated,
            "processor time of the server a simulated second [s]": server_cpu / simulated,
            "answer to a key, median [ms]": answer(page),
            "memory of the page's scripts [MB]": heap(session),
            "memory of the server, peak [MB]": peak(server),
            "first load, gzip [kB]": loaded(checkout),
        }


@contextmanager
def served(checkout: Path) -> Iterator[tuple[int, str]]:
    """Serve the gallery; yield the number of the process and a one-time address."""
    words = [checkout / ".venv" / "bin" / "mjsim", "studio", "--no-browser", checkout / "worlds" / "gallery.yaml"]
    process = subprocess.Popen(words, cwd=checkout, text=True, stderr=subprocess.PIPE)
    try:
        assert process.stderr is not None
        line = next(line for line in process.stderr if "token=" in line)
        yield process.pid, next(word for word in line.split() if word.startswith("http"))
    finally:
        process.terminate()
        process.wait()


def answer(page: Page) -> float:
    """Pause the run, and return how long single ticks take [ms]."""
    page.get_by_role("button", name="Pause", exact=True).click()
    page.get_by_role("button", name="Resume", exact=True).wait_for()
    took = []
    for _ in range(TICKS):
        before = page.locator("#view-run .run-time").text_content()
        began = time.perf_counter()
        page.keyboard.press(".")
        page.wait_for_function(ANSWERED, arg=before)
        took.append(1e3 * (time.perf_counter() - began))
        page.wait_for_timeout(100)  # a person does not press on within an answer
    return statistics.median(took)


def browsers() -> float:
    """Return the processor time of all processes of the browser so far [s]: those that draw, too."""
    parents = {}
    for each in Path("/proc").glob("[0-9]*/stat"):
        with suppress(OSError):
            parents[int(each.parent.name)] = int(each.read_text().rpartition(")")[2].split()[1])
    mine, count = {os.getpid()}, 0
    while len(mine) > count:
        count = len(mine)
        mine |= {process for process, parent in parents.items() if parent in mine}
    return sum(processor(each) for each in mine if "chrom" in Path(f"/proc/{each}/comm").read_text())


def heap(session: CDPSession) -> float:
    """Return the memory that scripts hold after a collection [MB]."""
    session.send("HeapProfiler.collectGarbage")
    return session.send("Runtime.getHeapUsage")["usedSize"] / MB


def processor(process: int) -> float:
    """Return the processor time of a process with its threads so far [s]."""
    user, system = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[11:13]
    return (int(user) + int(system)) / 100


def peak(process: int) -> float:
    """Return the largest memory that a process had [MB]."""
    lines = Path(f"/proc/{process}/status").read_text().splitlines()
    return next(int(line.split()[1]) for line in lines if line.startswith("VmHWM")) * 1024 / MB


def loaded(checkout: Path) -> float:
    """Return the size of what the page loads first [kB]."""
    static = next(each for each in (checkout / "mjsim/web/static", checkout / "mjsim/static") if each.is_dir())
    return sum(len(gzip.compress((static / name).read_bytes(), 9)) for name in FIRST_LOAD) / 1e3


if __name__ == "__main__":
    sys.exit(main())
