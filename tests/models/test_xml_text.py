"""XML of others is decoded once and then checked: no encoding hides what a document type would declare."""

import codecs
import re
import time
from xml.etree import ElementTree

import pytest

from mjsim.errors import UsageError
from mjsim.exchange import RobotOptions, bring_file, bring_robot
from mjsim.models import RefusedXmlError, checked_xml, gather_model

BODY = '<robot name="über"><link name="a"/></robot>'
BOMB = '<!DOCTYPE r [<!ENTITY a "aaaa"><!ENTITY b "&a;&a;">]><robot name="&b;"/>'
ENCODINGS = {
    "UTF-8": ("utf-8", b""),
    "UTF-8 with a mark": ("utf-8", codecs.BOM_UTF8),
    "UTF-16 with a mark": ("utf-16-le", codecs.BOM_UTF16_LE),
    "UTF-16, high bytes first": ("utf-16-be", codecs.BOM_UTF16_BE),
    "UTF-16 without a mark": ("utf-16-le", b""),
    "UTF-16 without a mark, high bytes first": ("utf-16-be", b""),
    "UTF-32 with a mark": ("utf-32-le", codecs.BOM_UTF32_LE),
    "UTF-32 without a mark, high bytes first": ("utf-32-be", b""),
    "Latin-1": ("iso-8859-1", b""),
    "windows-1252": ("windows-1252", b""),
}
DECLARED = pytest.mark.parametrize("declared", ["", '<?xml version="1.0"?>', '<?xml version="1.0" encoding="{}"?>'])


def written(text: str, encoding: str, declared: str) -> bytes:
    codec, mark = ENCODINGS[encoding]
    return mark + (declared.format(codec.removesuffix("-le").removesuffix("-be")) + text).encode(codec)


@DECLARED
@pytest.mark.parametrize("encoding", [name for name in ENCODINGS if name.startswith("UTF")])
def test_a_file_is_the_same_in_every_unicode_encoding(encoding, declared):
    tree = ElementTree.fromstring(checked_xml(written(BODY, encoding, declared)))
    assert ElementTree.tostring(tree) == ElementTree.tostring(ElementTree.fromstring(BODY))


@pytest.mark.parametrize("encoding", ["Latin-1", "windows-1252"])
def test_a_file_says_in_which_single_byte_encoding_it_is(encoding):
    text = checked_xml(written(BODY, encoding, '<?xml version="1.0" encoding="{}"?>'))
    assert ElementTree.fromstring(text).get("name") == "über"
    with pytest.raises(RefusedXmlError, match=r"^cannot be read as XML: it is not in utf-8; write it as UTF-8$"):
        checked_xml(written(BODY, encoding, ""))


@DECLARED
@pytest.mark.parametrize("encoding", ENCODINGS)
def test_no_encoding_hides_a_document_type(encoding, declared):
    with pytest.raises(RefusedXmlError, match=r"declares a document type; leave <!DOCTYPE \.\.\.> out"):
        checked_xml(written(BOMB, encoding, declared))
    with pytest.raises(RefusedXmlError, match="declares the XML entity 'a'"):
        checked_xml(written(BOMB, encoding, declared), doctype=True)


@pytest.mark.parametrize(
    "name", ["utf-7", "utf_7", "unicode_escape", "idna", "hex", "zip", "cp037", "gibberish", "rot13"]
)
def test_encodings_in_which_a_tag_may_be_spelled_otherwise_are_refused(name):
    hidden = '+ADwAIQ-DOCTYPE r [+ADw-!ENTITY a "b">]><robot name="&a;"/>'
    with pytest.raises(RefusedXmlError, match=rf"its encoding is {re.escape(name)}; write it as UTF-8"):
        checked_xml(f'<?xml version="1.0" encoding="{name}"?>{hidden}'.encode())


def test_a_mark_goes_before_what_the_declaration_says():
    with pytest.raises(RefusedXmlError, match="declares a document type"):
        checked_xml(codecs.BOM_UTF16_LE + f'<?xml version="1.0" encoding="utf-8"?>{BOMB}'.encode("utf-16-le"))


def test_a_document_type_may_be_named_where_it_declares_nothing():
    named = '<!DOCTYPE svg PUBLIC "-//W3C//DTD SVG 1.1//EN" "http://www.w3.org/Graphics/SVG/1.1/DTD/svg11.dtd"><svg/>'
    assert ElementTree.fromstring(checked_xml(named.encode(), doctype=True)).tag == "svg"
    many = "".join(f'a{k} CDATA "x" ' for k in range(9))
    with pytest.raises(RefusedXmlError, match="declares attributes of <g>"):
        checked_xml(f"<!DOCTYPE svg [<!ATTLIST g {many}>]><svg><g/></svg>".encode(), doctype=True)


def test_positions_in_a_checked_text_are_those_of_the_file():
    data = b'\n\n<?xml version="1.0"\n encoding="utf-8"?>\n<robot>\n  <link>\n</robot>'
    with pytest.raises(ElementTree.ParseError) as caught:
        ElementTree.fromstring(checked_xml(data))
    assert caught.value.position == (7, 2)


@pytest.mark.parametrize(
    ("written", "read"),
    [
        ("<!-- gz sim --levels -->", "<!-- gz sim   levels -->"),
        ("<!----->", "<!-- -->"),
        ("<!-- a-b -->", "<!-- a-b -->"),
        ("<![CDATA[<!-- -- -->]]><!-- -- -->", "<![CDATA[<!-- -- -->]]><!--    -->"),
        ("<!-- <![CDATA[ --><b/><!--x-->", "<!-- <![CDATA[ --><b/><!--x-->"),
        ("<!-- a -- b", "<!-- a -- b"),  # never closed: the parser says so
    ],
)
def test_two_hyphens_in_a_comment_are_borne_as_gazebo_and_ros_bear_them(written, read):
    assert checked_xml(f"<a>{written}</a>".encode()) == f"<a>{read}</a>"
    if written.endswith(">"):
        ElementTree.fromstring(read.join(("<a>", "</a>")))


def test_comments_that_are_never_closed_take_no_long_time():
    begun = time.process_time()
    assert len(checked_xml(b"<a>" + b"<!-- -- " * 400_000)) == 3_200_003
    assert time.process_time() - begun < 2.0


def test_prefixes_without_a_declaration_are_declared_behind_any_text():
    text = checked_xml('<!-- ü --><röbot><a:b c:d="1"/></röbot>'.encode())
    tags = [item.tag for item in ElementTree.fromstring(text).iter()]
    assert tags == ["röbot", "{undeclared:a}b"]


def bring(place):
    """Import a drawing or a robot."""
    if place.suffix == ".svg":
        return bring_file(place, robot=None)
    return bring_robot(place, name="r", options=RobotOptions(), packages={}, arguments={})


@pytest.mark.parametrize("encoding", ["UTF-8", "UTF-16 with a mark", "UTF-32 without a mark, high bytes first"])
def test_every_reader_of_robots_models_and_drawings_refuses_entities(encoding, tmp_path):
    for ending in ("urdf", "urdf.xacro", "xml", "svg"):
        place = tmp_path / f"bomb.{ending}"
        place.write_bytes(written(BOMB, encoding, ""))
        with pytest.raises(UsageError, match=r"declares (a document type|the XML entity)") as caught:
            bring(place)
        assert len(str(caught.value).splitlines()) == 1
    with pytest.raises(ValueError, match=r"'bomb.xml' declares a document type"):
        gather_model("bomb.xml", lambda name: (tmp_path / name).read_bytes())
