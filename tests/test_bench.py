"""The measurements of `mjsim bench`: what they print, and that rivals are drawn as they should be."""

import importlib.util
import math

import mujoco
import numpy as np
import pytest

from mjsim.bench import measure
from mjsim.bench.asked import ASKED, ASKED_OF_PEERS, Asked, verdict
from mjsim.bench.figures import FIGURES
from mjsim.bench.naive import blocks_of, naive_scene, put, stock_renderer
from mjsim.bench.peers import PEER_FIGURES, irsim_world
from mjsim.bench.scenes import gallery, gallery_places, hall, office
from mjsim.errors import UsageError, how_to_install
from mjsim.sim import Simulation


def test_peers_that_are_missing_are_told_with_the_command_that_installs_both(monkeypatch):
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    with pytest.raises(UsageError, match=f"^ir-sim is not installed; type: {how_to_install('ir-sim', 'pybullet')}$"):
        list(measure(["irsim-lidar"], runs=1, peers=True))


def test_a_table_has_a_line_a_figure_with_median_min_max_unit_and_runs():
    head, line = measure(["filter-10"], runs=3)
    assert head.split() == ["figure", "median", "min", "max", "unit", "runs"]
    name, median, least, most, *unit, runs = line.split()
    assert (name, " ".join(unit), runs) == ("filter-10", "ms a predict and update", "3")
    assert 0.0 < float(least) <= float(median) <= float(most)


def test_a_ratio_is_taken_run_by_run_and_its_median_counts():
    asked = Asked("pictures, times theirs", ("ours", "theirs"), lambda ours, theirs: ours / theirs, "at least", 3.0)
    # The machine was ten times slower in the second run, and in the third while ours was measured.
    line = verdict(asked, {"ours": [40.0, 4.0, 4.0], "theirs": [10.0, 1.0, 10.0]})
    assert line.split() == ["pictures,", "times", "theirs", "4", "at", "least", "3", "holds"]
    assert verdict(asked, {"ours": [20.0], "theirs": [10.0]}).endswith("FAILS")


@pytest.mark.slow
def test_what_is_asked_follows_when_all_its_figures_are_measured():
    *_, head, line = measure(["pictures-floor", "sense-640x480", "filter-10"], runs=1)
    assert head.startswith("asked")
    assert line.startswith("a gallery picture, times the floor's cost")


def test_everything_asked_is_of_figures_that_are_measured():
    known = {figure.name for figure in (*FIGURES, *PEER_FIGURES)}
    assert len(known) == len(FIGURES) + len(PEER_FIGURES)
    assert {name for asked in (*ASKED, *ASKED_OF_PEERS) for name in asked.of} <= known


def test_an_unknown_figure_is_named_with_what_it_may_be():
    with pytest.raises(UsageError, match=r"no figure 'lop'; did you mean 'loop'\?"):
        list(measure(["lop"], runs=1))


@pytest.mark.slow
def test_the_office_has_two_thousand_walls_and_the_hall_a_hundred():
    assert sum(len(wall.segments()) for wall in office(2000, 64, 48).walls) == 2000
    assert sum(len(wall.segments()) for wall in hall().walls) == 100
    assert irsim_world(hall()).count("rectangle") == 100


@pytest.mark.slow
def test_the_gallery_written_naively_has_a_geom_a_wall_and_what_mujoco_draws_unless_told_otherwise():
    world = gallery()
    model = naive_scene(world, width=64, height=48, lamps=[(4.0, 5.0), (10.0, 5.0)])
    assert model.ngeom == len(blocks_of(world)) + 2  # the floor and what stands for the robot
    assert model.light_castshadow.all()
    assert (model.vis.quality.shadowsize, model.vis.quality.offsamples) == (4096, 4)


@pytest.mark.slow
def test_stock_mujoco_sees_the_same_gallery():
    world, place = gallery(), gallery_places()[3]
    model = naive_scene(world, width=160, height=120, lamps=[(4.0, 5.0), (10.0, 5.0)])
    data = mujoco.MjData(model)
    put(model, data, place)
    with stock_renderer(model, width=160, height=120) as renderer, Simulation(world) as sim:
        renderer.update_scene(data, "front")
        renderer.enable_depth_rendering()
        depth = renderer.render()
        sim.move("scout", place)
        ours = sim.model.camera("scout/front").id
        # The least way along the middle of the picture is the same, as both cameras stand at the same place.
        axis = -sim.data.cam_xmat[ours].reshape(3, 3)[:, 2]
        groups = np.array([1, 1, 0, 1, 0, 0], dtype=np.uint8)
        hit = mujoco.mj_ray(sim.model, sim.data, sim.data.cam_xpos[ours], axis, groups, 1, -1, np.zeros(1, np.int32))
    assert math.isclose(hit, float(depth[60, 80]), rel_tol=0.02)
