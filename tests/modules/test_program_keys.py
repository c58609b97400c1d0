"""Keys in the answers of programs."""

import pytest

import mjsim
from tests.modules.test_programs import room, script


@pytest.mark.slow
def test_keys_of_its_own_in_an_answer_do_no_harm_and_a_misspelt_one_is_told(tmp_path):
    answer = 'read a; echo \'{}\'; while read a; do echo \'{"%s": 0.3, "comment": true, "seen": [1]}\'; done\n'
    for key in ("forward", "foward"):
        script(tmp_path, key, answer.replace("%s", key), head="#!/bin/sh\n")
    with mjsim.Simulation(room(tmp_path, "navigator: {use: 'exec:./forward'}")) as sim:
        assert mjsim.run(sim, seconds=1.0).robots["scout"].truth[-1, 0] > 0.1
    with (
        mjsim.Simulation(room(tmp_path, "navigator: {use: 'exec:./foward'}")) as sim,
        pytest.raises(mjsim.ModuleFault, match="answered with the key 'foward'; did you mean 'forward'"),
    ):
        mjsim.run(sim, seconds=1.0)
