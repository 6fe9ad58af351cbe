"""Files built to hurt: huge, deep or packed, with numbers and types that no reader of theirs expects.

What can be done to a file follows from its content alone, so that a new reader is tried without a line here.
"""

import copy
import gzip
import io
import json
import re
import zipfile
from typing import Any

from hypothesis import strategies as st
from hypothesis.strategies import DrawFn

from acf_jax.documents import parse_yaml
from tests.fuzz.mutate import places

DOCUMENTS = (".yaml", ".json", ".eqx")  # the last begins with a line of JSON
LONG = 25_000_000  # bytes; more than a document may have
BOMB = 300_000_000  # bytes that a packed file unpacks to
SPARSE = 3 << 30  # bytes that a file says to have without taking any

NUMERALS = tuple(
    numeral.encode()
    for numeral in (
        "9" * 400, "-" + "9" * 5000, "0." + "9" * 5000, "1" + "0" * 300, "1e400", "-1e400", "1e308", "-1e308", "1e100",
        "1e15", "1e9", "1.5", "0", "-0", "-0.0", "-1", "5e-324", "1e-320", "2147483648", "4294967295",
        "9223372036854775808", "nan", "NaN", ".nan", "inf", "-.inf", "Infinity", "NaT", "0x1F", "0o17", "0b1", "010",
        "1:30", "1_000", "1,5", "true", "yes", "null", "~", "", '"1"', "'1'", "\u0967", "2024-01-01", "[1]", "{a: 1}",
    )
)  # fmt: skip
_NUMERAL = re.compile(rb"(?<![\w.])[-+]?\d+(\.\d*)?([eE][-+]?\d+)?(?![\w.])")
FILLERS = (
    b" ", b"\t", b"\0", b"\n", b"\r", b"x", b"9", b"-", b".", b",", b";", b"1,", b"1 ", b"1,2\n", b'"', b"'", b'"\n",',
    b"[", b"{", b"(", b"[],", b"{},", b"[[],", b'{"a":', b"a: ", b"a,", b"- ", b"? ", b"&a ", b"*a,", b"!", b"#", b"\\",
    b"\\u0000", b"\xff", b"\xc3\xa9", b"0x", b"1e", b"<a>", b"&lt;",
)  # fmt: skip
COUNTS = (-1, 0, 1, 2**31 - 1, 2**31, 2**32 - 1, 10**9, 2**40, 2**62, 2**63 - 1, 2**64 - 1)
REPLACED = (
    None,
    True,
    False,
    "",
    "x",
    0,
    -1,
    [],
    {},
    [[]],
    {"": {}},
    "1",
    "nan",
    10**400,
    [0] * 5000,
    {"a": 1},
    "x" * 10**6,
)


class Sparse(bytes):
    """The beginning of a file that goes on with zeros for `SPARSE` bytes."""

    def __repr__(self) -> str:
        return f"Sparse({super().__repr__()})"


def built(name: str, content: bytes) -> st.SearchStrategy[bytes]:
    """What may be made of the file `name`, given a whole one."""
    ways = [numerals(content), long(content), st.just(Sparse(content))]
    if name.endswith(DOCUMENTS):
        ways += [types(name, content), types(name, content), crowded(name, content)]
    if not _is_text(content):
        ways += [counts(content), counts(content)]
    if content.startswith(b"\x1f\x8b"):
        ways.append(packed(content))
    if content.startswith(b"PK"):
        ways.append(zipped(content))
    return st.one_of(ways)


@st.composite
def numerals(draw: DrawFn, content: bytes) -> bytes:
    """Numbers in other forms, wherever digits stand alone."""
    found = list(_NUMERAL.finditer(content))
    for _ in range(draw(st.integers(1, 2)) if found else 0):
        at = draw(st.sampled_from(found))
        new = draw(st.sampled_from(NUMERALS))
        content = content[: at.start()] + new + content[at.end() :]
        found = list(_NUMERAL.finditer(content))
        if not found:
            break
    return content


@st.composite
def long(draw: DrawFn, content: bytes) -> bytes:
    """A line, a cell, a row, a level or an item again and again, behind any part of the file, or in place of it."""
    lines = content.splitlines(keepends=True)
    begin = b"".join(lines[: draw(st.integers(0, min(len(lines), 5)))])
    if draw(st.booleans()):
        begin = begin.rstrip(b"\r\n")
    filler = draw(st.sampled_from(FILLERS) | st.sampled_from(lines[:50] or [b""]))
    size = draw(st.sampled_from((1000, 200_000, LONG)))
    return (
        begin
        + filler * (size // max(len(filler), 1))
        + (content[len(begin) :] if draw(st.booleans()) else b"")
    )


@st.composite
def types(draw: DrawFn, name: str, content: bytes) -> bytes:
    """A document with values of other types: lists for scalars, mappings for lists, nothing for either."""
    value, write = _document(name, content)
    for _ in range(draw(st.integers(1, 2))):
        if everywhere := list(places(value)):
            holder, key = draw(st.sampled_from(everywhere))
            old = holder[key]
            kept = [[old], {"value": old}, [old] * 3, [old] * 2000]
            holder[key] = copy.deepcopy(draw(st.sampled_from([*REPLACED, *kept])))
    return write(value)


@st.composite
def crowded(draw: DrawFn, name: str, content: bytes) -> bytes:
    """A document one of whose lists or mappings has very many items, or goes very deep."""
    value, write = _document(name, content)
    holders = [holder[key] for holder, key in places(value) if isinstance(holder[key], list | dict)]
    holder = draw(st.sampled_from([value, *holders]))
    count = draw(st.sampled_from((30, 100, 20_000, 300_000)))
    item: Any = draw(st.sampled_from((None, 0, "x", [], {})))
    if draw(st.booleans()) and count <= 100:
        for _ in range(count):
            item = [item]
        count = 1
    if isinstance(holder, dict):
        holder |= {f"k{k}": item for k in range(count)}
    elif isinstance(holder, list):
        holder += [item if draw(st.booleans()) or not holder else holder[0]] * count
    return write(value)


@st.composite
def counts(draw: DrawFn, content: bytes) -> bytes:
    """Binary numbers, such as lengths and sizes in headers, in place of any bytes; more often near either end."""
    found = bytearray(content)
    for _ in range(draw(st.integers(1, 3))):
        width, order = draw(st.sampled_from((1, 2, 4, 8))), draw(st.sampled_from(("little", "big")))
        reach = draw(st.sampled_from((64, 1000, len(found))))
        at = draw(st.integers(0, max(0, min(reach, len(found)) - width)))
        at = draw(st.sampled_from((at, max(0, len(found) - width - at))))
        value = draw(st.sampled_from(COUNTS)) % (1 << 8 * width)
        found[at : at + width] = value.to_bytes(width, order)
    return bytes(found)


@st.composite
def packed(draw: DrawFn, content: bytes) -> bytes:
    """Very much of one thing, packed by gzip behind the beginning of what was there."""
    begin = gzip.decompress(content)[: draw(st.sampled_from((0, 100)))]
    return gzip.compress(begin + _filling(draw(st.sampled_from(FILLERS))), compresslevel=1)


@st.composite
def zipped(draw: DrawFn, content: bytes) -> bytes:
    """A zip archive one of whose members holds very much of one thing, or that many, or a number in another form."""
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        members = {name: archive.read(name) for name in archive.namelist()}
    name = draw(st.sampled_from(sorted(members)))
    what = draw(st.sampled_from(("much", "many", "numeral", "count", "gone")))
    if what == "much":
        begin = members[name][: draw(st.sampled_from((0, 128, len(members[name]))))]
        members[name] = begin + _filling(draw(st.sampled_from(FILLERS)))
    elif what == "many":
        members |= {f"{k}{name}": members[name][:200] for k in range(3000)}
    elif what == "gone":
        del members[name]
    else:
        members[name] = draw((numerals if what == "numeral" else counts)(members[name]))
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive:
        for name, member in members.items():
            archive.writestr(name, member)
    return out.getvalue()


def _filling(filler: bytes) -> bytes:
    return filler * (BOMB // len(filler))


def _is_text(content: bytes) -> bool:
    try:
        return b"\0" not in content and bool(content.decode())
    except UnicodeDecodeError:
        return False


def _document(name: str, content: bytes) -> tuple[Any, Any]:
    """The value of a document, and what writes another one in its place."""
    line, newline, body = content.partition(b"\n") if name.endswith(".eqx") else (content, b"", b"")
    value = parse_yaml(line.decode(), name) if name.endswith(".yaml") else json.loads(line)
    return (
        value,
        lambda value: json.dumps(value).encode() + newline + body,
    )  # JSON is YAML, written much faster
