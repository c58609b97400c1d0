"""Scales of meshes as people write them."""

from xml.etree.ElementTree import fromstring

import pytest

from mjsim.models.scales import mend_scales


@pytest.mark.parametrize(
    ("written", "read"),
    [("1 1 1 1", "1 1 1"), ("0.001", "0.001 0.001 0.001"), ("1, 2, 3", "1 2 3"), ("1 2 3", "1 2 3"), ("1 2", "1 2")],
)
def test_a_scale_of_a_mesh_has_three_numbers_if_they_are_clear(written, read):
    root = fromstring(f'<robot><mesh scale="{written}"/><mesh/></robot>')
    said = list(mend_scales(root))
    assert root[0].get("scale") == read
    assert bool(said) == (written != read)
    assert root[1].get("scale") is None
