"""What a number, a key and a word are in YAML and JSON, and what is refused before it costs time or memory."""

import gzip
import math
from typing import Any

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from acf_jax import documents
from acf_jax.documents import is_number, parse_json, parse_yaml, yaml_text
from acf_jax.errors import InputError
from acf_jax.files import read_text, unpacked


@pytest.fixture(params=sorted({"SafeLoader", documents._Loader.__name__}), autouse=True)
def loader(request, monkeypatch) -> None:
    """PyYAML with and without libyaml."""
    monkeypatch.setattr(documents, "_Loader", getattr(yaml, request.param))


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("010", 10), ("08", 8), ("-010", -10), ("+3", 3), ("0", 0), ("010.5", 10.5), ("1e3", 1000.0), ("1e-3", 1e-3),
        (".5e1", 5.0), ("1.", 1.0), ("3.4e5", 3.4e5), ("1" + 30 * "0", 10**30),
        ("true", True), ("FALSE", False), ("~", None), ("null", None), ("", None),
        (".inf", math.inf), ("-.Inf", -math.inf),
        # text, since only YAML 1.1 takes it for something else
        ("1:30", "1:30"), ("190:20:30", "190:20:30"), ("0x1F", "0x1F"), ("0o17", "0o17"), ("0b101", "0b101"),
        ("1_000", "1_000"), ("yes", "yes"), ("No", "No"), ("on", "on"), ("off", "off"), ("y", "y"),
        ("2024-01-01", "2024-01-01"), ("2024-13-45", "2024-13-45"), ("=", "="), ("inf", "inf"), ("nan", "nan"),
        ("1,5", "1,5"), ("\u0967", "\u0967"), ("'010'", "010"), ('"true"', "true"), ("[010, a]", [10, "a"]),
    ],
)  # fmt: skip
def test_what_a_value_of_yaml_is(text: str, value: Any) -> None:
    (found,) = parse_yaml(f"a: {text}", "f").values()
    assert found == value and type(found) is type(value)


def test_keys_of_yaml_are_text() -> None:
    text = "on: 1\nno: 2\n010: 3\n1.5: 4\ntrue: 5\n~: 6\n2024-01-01: 7\n<<: {a: 8}\n"
    assert list(parse_yaml(text, "f")) == ["on", "no", "010", "1.5", "true", "~", "2024-01-01", "<<"]


LAUGHS = "a: &a [x, x]\n" + "\n".join(
    f"{b}: &{b} [*{a}, *{a}]" for a, b in zip("abcdefgh", "bcdefghi", strict=True)
)


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        (LAUGHS, "f line 2: aliases (*name) are not known; write values out; correct the YAML"),
        ("a: 1\nb: 2\na: 3", "f line 3: key 'a' is given twice; correct the YAML"),
        ("1: a\n'1': b", "f line 2: key '1' is given twice; correct the YAML"),
        ("x: 1\na: " + "9" * 400, "f line 2: '99999999999999999...999999999999999999' is larger"),
        ("a: -1e400", "f line 1: '-1e400' is larger, or longer, than any number that can be computed with"),
        ("a: " + "0" * 5000, "f line 1: '00000000000000000...000000000000000000' is larger, or longer, than"),
        ("a: !!python/object/apply:os.system [x]", "f line 1: tags ('tag:yaml.org,2002"),
        ("a: !!float x", "f line 1: tags ('tag:yaml.org,2002:float') are not known"),
        ("? [1, 2]\n: 3", "f line 1: a key must be text"),
        ("a: 1\n---\nb: 2", "f line 2: a second document begins here"),
        ("a: " + "[" * 500, "f line 1: nested too deeply"),
        ("a: [" + "[]," * 1000 + "]", "f line 1: more than 1,000 values"),
        ("a: " + "x" * 5_000_000, "f: is larger than the 5 MB that a YAML file may have"),
        ("a: \ud800", "f: "),
    ],
)  # fmt: skip
def test_what_yaml_is_refused(text: str, fault: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(documents.MOST_VALUES, "YAML", 1000)
    with pytest.raises(InputError) as error:
        parse_yaml(text, "f")
    assert error.value.faults[0].startswith(fault)


def test_an_empty_document_holds_nothing() -> None:
    assert [parse_yaml(text, "f") for text in ("", "# words", "---\n...\n")] == [None] * 3


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        ('{"a": NaN}', "f: holds NaN, which is no number; again"),
        ('{"a": -Infinity}', "f: holds -Infinity, which is no number; again"),
        ('{"a": 1e400}', "f: '1e400' is larger"),
        ('{"a": 1' + "0" * 400 + "}", "f: '10000"),
        ('{"a": 1, "a": 2}', "f: key 'a' is given twice; again"),
        ("[" * 100_000, "f: is nested too deeply; again"),
        ("[" * 50 + "]" * 50, "f: is nested too deeply; again"),
        ('["\\ud800"]', "f: holds half a character; again"),
        ("[010]", "f: is not JSON"),
        ("[" + "0," * 1_000_001 + "0]", "f: holds more than 1,000,000 values; again"),
        (" " * 20_000_001, "f: is larger than the 20 MB that a JSON file may have; again"),
    ],
)  # fmt: skip
def test_what_json_is_refused(text: str, fault: str) -> None:
    with pytest.raises(InputError) as error:
        parse_json(text, "f", "again")
    assert error.value.faults[0].startswith(fault)


LEAVES = (
    st.none()
    | st.booleans()
    | st.integers(-(10**300), 10**300)
    | st.floats(allow_nan=False, allow_infinity=False)
    | st.text(st.characters(exclude_categories=("C",)), max_size=8)
    | st.sampled_from(
        ("08", "010", "1e3", "1e-3", ".5", "1:30", "yes", "~", "null", "2024-01-01", "<<", "=", "")
    )
)


@given(st.dictionaries(st.text("ab01~", max_size=3), st.lists(LEAVES, max_size=4), max_size=4))
def test_yaml_that_is_written_reads_as_it_was(value: dict[str, Any]) -> None:
    shared = {"one": value, "two": value}  # which other writers turn into an alias
    assert repr(parse_yaml(yaml_text(shared), "f")) == repr(shared)


@pytest.mark.parametrize(
    "value", [True, False, "1", None, math.inf, -math.inf, math.nan, 10**400, -(10**400), [1]]
)
def test_what_is_no_number(value: Any) -> None:
    assert not is_number(value)


def test_what_is_one() -> None:
    assert all(map(is_number, (0, -0.0, 1e308, 10**308, 5e-324)))


def test_packed_text_is_bounded_before_it_is_unpacked() -> None:
    packed = gzip.compress(b" " * 50_000_000)
    with pytest.raises(InputError, match=r"f: unpacks to more than 1 MB; again"):
        unpacked(packed, "f", "again", 1_000_000)
    assert unpacked(packed, "f", "again", 50_000_000) == b" " * 50_000_000
    for wrong, fault in (
        (packed[:-4], "f: is cut off; again"),
        (b"", "f: is cut off; again"),
        (packed + b"x", "f: more stands behind its end; again"),
        (packed + packed, "f: more stands behind its end; again"),
        (b"\0" + packed, "f: cannot be unpacked"),
    ):
        with pytest.raises(InputError) as error:
            unpacked(wrong, "f", "again", 50_000_000)
        assert error.value.faults[0].startswith(fault)


def test_a_file_is_read_to_its_bound(tmp_path) -> None:
    (tmp_path / "long").write_bytes(b"x" * 2_000_001)
    with pytest.raises(InputError, match="is larger than 2 MB; cut it to what is needed"):
        read_text(tmp_path / "long", 2_000_000)
    assert len(read_text(tmp_path / "long", 2_000_001)) == 2_000_001
