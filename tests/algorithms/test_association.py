"""Sightings without names: pairings against all pairings there are, and a building without a single name."""

import dataclasses
import itertools
import json
from collections import Counter, defaultdict

import numpy as np
import pytest
from scipy.stats import chi2
from threadpoolctl import threadpool_limits

from mjsim.algorithms.ekf_slam import ekf_slam
from mjsim.algorithms.ekf_slam.association import joint_compatibility, nearest_neighbour
from mjsim.algorithms.ekf_slam.ekf_slam import EkfSlam, EkfSlamFilter, odometry_motion
from mjsim.algorithms.estimation.ekf_models import range_bearing
from mjsim.geometry import Pose, wrap_angles
from mjsim.interface import Observation, Odometry, Sighting
from tests.algorithms.golden import DATA, golden
from tests.robots import pioneer

R = np.diag([0.05, np.radians(2.0)]) ** 2


def lost_among(places, *, seed):
    """Return a filter that has seen the places well and then lost its way a little, and where it really is."""
    rng = np.random.default_rng(seed)
    slam, truth = EkfSlamFilter(), np.zeros(3)
    z, _, _ = range_bearing(truth, places)
    slam.update(list(range(len(places))), z + rng.normal(0, 0.01, z.shape), R / 100)
    spread = np.diag([0.2, 0.2, 0.1]) ** 2
    step = rng.multivariate_normal(np.zeros(3), spread)
    slam.predict(odometry_motion(), (0.5, 0.0, 0.1), spread)
    return slam, odometry_motion()(truth, np.array([0.5, 0.0, 0.1]) + step)[0], rng


def best_of_all(slam, Z, confidence=0.999):
    """Try every pairing; return the size and the distance of the best that passes the joint gate."""
    names = list(slam.names())
    expected, _ = slam.expect(names)
    C = slam.expect_together(names)
    best = (0, 0.0)
    for choice in itertools.product([None, *range(len(names))], repeat=len(Z)):
        pairs = [(row, column) for row, column in enumerate(choice) if column is not None]
        if not pairs or len({column for _, column in pairs}) < len(pairs):
            continue
        at = [2 * column + i for _, column in pairs for i in (0, 1)]
        nu = np.array([Z[row] - expected[column] for row, column in pairs])
        nu[:, 1] = wrap_angles(nu[:, 1])
        S = C[np.ix_(at, at)] + np.kron(np.eye(len(pairs)), R)
        distance = float(nu.ravel() @ np.linalg.solve(S, nu.ravel()))
        if distance < chi2.ppf(confidence, 2 * len(pairs)):
            best = max(best, (len(pairs), -distance))
    return best[0], -best[1]


@pytest.mark.parametrize("seed", range(12))
def test_joint_compatibility_finds_the_best_of_all_pairings(seed):
    places = np.random.default_rng(seed).uniform([1.0, -2.0], [4.0, 2.0], (4, 2))
    slam, truth, rng = lost_among(places, seed=seed)
    seen = places[rng.permutation(4)[:3]]
    Z = range_bearing(truth, seen)[0] + rng.normal(0, np.sqrt(np.diag(R)), (3, 2))
    names = joint_compatibility(slam, Z, R)
    pairs = [row for row, name in enumerate(names) if name is not None]
    size, distance = best_of_all(slam, Z)
    assert len(pairs) == size
    chosen = [names[row] for row in pairs]
    nu = Z[pairs] - slam.expect(chosen)[0]
    nu[:, 1] = wrap_angles(nu[:, 1])
    S = slam.expect_together(chosen) + np.kron(np.eye(len(pairs)), R)
    assert nu.ravel() @ np.linalg.solve(S, nu.ravel()) == pytest.approx(distance)


def test_joint_compatibility_finds_errors_of_individual_associations():
    """The robot is 0.8 m ahead of where it believes to be, among marks 0.8 m apart: each seems to be the one before."""
    places = np.array([[2.0 + 0.8 * k, (-1.0) ** k * 1.5] for k in range(5)] + [[6.5, 0.3]])
    slam = EkfSlamFilter()
    slam.update(list("abcdef"), range_bearing(np.zeros(3), places)[0], R / 100)
    slam.predict(odometry_motion(), (0.0, 0.0, 0.0), np.diag([0.5, 0.05, 0.02]) ** 2)
    Z = range_bearing(np.array([0.8, 0.0, 0.0]), places[1:])[0]
    assert joint_compatibility(slam, Z, R) == list("bcdef")


def test_no_landmark_is_paired_twice_and_a_strange_sighting_not_at_all():
    slam = EkfSlamFilter()
    slam.update(["a", "b"], [[2.0, 0.0], [2.0, 0.5]], R)
    Z = np.array([[2.02, 0.01], [2.0, 0.02], [6.0, -1.0]])
    for pair in (nearest_neighbour, joint_compatibility):
        names = pair(slam, Z, R)
        assert names.count("a") == 1
        assert names[2] is None


def test_an_empty_map_pairs_nothing():
    for pair in (nearest_neighbour, joint_compatibility):
        assert pair(EkfSlamFilter(), [[2.0, 0.0]], R) == [None]


def pairings_without_names(run, association, monkeypatch):
    """Drive a golden run without names; return the estimator's last belief and (identity, landmark) of each pair."""
    config = json.loads((DATA / "config.json").read_text())
    dt, wheelbase = config["period_s"], config["wheelbase_m"]
    Q = np.diag([config["sigma_speed_mps"], np.radians(config["sigma_steering_deg"])]) ** 2
    noise = np.diag([config["sigma_range_m"], np.radians(config["sigma_bearing_deg"])]) ** 2
    named, pair = [], ekf_slam._ASSOCIATIONS[association]

    def listening(slam, Z, R, **rest):
        named.append(pair(slam, Z, R, **rest))
        return named[-1]

    monkeypatch.setitem(ekf_slam._ASSOCIATIONS, association, listening)
    slam = EkfSlam(association=association)
    at_origin = dataclasses.replace(pioneer(), prior=Pose(0, 0, 0), prior_covariance=np.zeros((3, 3)))
    slam.start(at_origin, {}, np.random.default_rng(0))
    bounds = np.searchsorted(run["observation_step"], np.arange(len(run["control"]) + 1))
    seen = []
    for k, (speed, steering) in enumerate(run["control"]):
        step, c, s = speed * dt, np.cos(steering), np.sin(steering)
        G = np.array([[dt * c, -step * s], [dt * s, step * c], [dt * s / wheelbase, step * c / wheelbase]])
        moved = Odometry(step * c, step * s, step * s / wheelbase, G @ Q @ G.T)
        now = slice(bounds[k], bounds[k + 1])
        sightings = tuple(Sighting(k * dt, None, *z, noise) for z in run["observation"][now])
        belief = slam.update(Observation(time=k * dt, dt=dt, odometry=moved, sightings=sightings))
        if sightings:
            seen.append(run["observation_id"][now].tolist())
    pairs = [
        (identity, name)
        for identities, names in zip(seen, named, strict=True)
        for identity, name in zip(identities, names, strict=True)
        if name is not None
    ]
    return belief, pairs


@pytest.mark.slow
@pytest.mark.parametrize(("number", "association"), [(1, "joint"), (3, "nearest")])
def test_a_building_is_mapped_without_a_single_name(number, association, monkeypatch):
    run = golden(f"atrium_{number}")
    run["control"] = run["control"][:3700]  # half of it: each beacon is seen at least three times
    with threadpool_limits(1, user_api="blas"):
        belief, pairs = pairings_without_names(run, association, monkeypatch)
    votes = defaultdict(Counter)
    for identity, name in pairs:
        votes[name][identity] += 1
    meant = {name: counts.most_common(1)[0][0] for name, counts in votes.items()}
    # Each landmark is one of the 48 beacons, and each beacon has one landmark.
    assert sorted(meant) == sorted(belief.landmarks)
    assert sorted(meant.values()) == list(range(48))
    # 99.3 to 99.6 %; wrong are neighbours 0.13 to 0.19 m apart, seen from afar.
    assert sum(votes[name][meant[name]] for name in meant) > 0.99 * len(pairs)
