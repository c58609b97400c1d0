"""Texts that hold more values than a world may are refused at once, before they are read."""

import time

import pytest

import mjsim

FLOW = f"mjsim: 1\nwalls: [{{points: [{', '.join(f'[{i}.5, 2.25]' for i in range(150_000))}]}}]\n"
BLOCK = "mjsim: 1\nwalls:\n- points:\n" + "".join(f"  - - {i}.5\n    - 2.25\n" for i in range(130_000))


@pytest.mark.slow
@pytest.mark.parametrize("text", [FLOW, BLOCK])
def test_megabytes_of_points_are_refused_at_once(text):
    assert len(text) > 2_000_000
    began = time.process_time()
    with pytest.raises(mjsim.WorldError, match="the text holds more than 250000 values") as caught:
        mjsim.parse_world(text)
    # It was 9.7 s; 0.1 to 0.3 s now, the rest is for machines that are slower.
    assert time.process_time() - began < 1.0
    assert len(caught.value.problems) == 1


def test_commas_in_texts_and_comments_are_no_values():
    text = f'mjsim: 1 # {"," * 200_000}\nname: "{"," * 200_000}"\n'
    with pytest.raises(mjsim.WorldError, match="it must have at most 64 characters"):
        mjsim.parse_world(text)
