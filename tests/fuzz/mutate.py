"""Files gone wrong: bytes, cells, keys and values that were changed, drawn by hypothesis."""

import copy
import csv
import io
import json
import math
from collections.abc import Iterator
from typing import Any

from hypothesis import strategies as st
from hypothesis.strategies import DrawFn

from acf_jax.documents import parse_yaml, yaml_text

PIECES = (
    b"",
    b",",
    b";",
    b'"',
    b"\n",
    b"\0",
    b"nan",
    b"-",
    b"1e999",
    b"&a [*a]",
    b"{",
    b"]",
    b"\xff\xfe",
    b"!!float x",
)
CELLS = (
    "",
    "nan",
    "inf",
    "-1",
    "0",
    "-0.0",
    "1e308",
    "1e-320",
    "1e15",
    "1,5",
    "x" * 5000,
    "=1+1",
    "a\0b",
    "../x",
    '"',
    "१",
    "1_0",
)
NUMBERS = (0, -1, 1e308, -1e308, 1e-308, 1e15, 1e-15, 10**400, math.inf, math.nan)
LEAVES = (
    st.sampled_from(NUMBERS)
    | st.none()
    | st.booleans()
    | st.integers(-9, 9)
    | st.floats()
    | st.text(max_size=8)
    | st.sampled_from(("x" * 5000, "/dev/zero", "..", "\0"))
)
KEYS = st.text(max_size=6)


def values(leaves: st.SearchStrategy[Any], keys: st.SearchStrategy[Any]) -> st.SearchStrategy[Any]:
    """Leaves, and lists and mappings of them."""
    return st.recursive(
        leaves,
        lambda inner: st.lists(inner, max_size=3) | st.dictionaries(keys, inner, max_size=3),
        max_leaves=5,
    )


OF_JSON = values(LEAVES, KEYS), KEYS
OF_YAML = values(LEAVES | st.dates(), KEYS | st.integers() | st.dates()), KEYS | st.integers() | st.none()


@st.composite
def mutated(draw: DrawFn, name: str, content: bytes) -> bytes:
    """The content of the file `name`, changed in a way that its form invites."""
    form = {".csv": cells, ".yaml": of_yaml, ".json": of_json, ".eqx": saved}.get(name[name.rfind(".") :])
    if form is None or draw(st.integers(0, 2)) == 0:
        return draw(st.binary(max_size=200)) if draw(st.integers(0, 9)) == 0 else draw(cut(content))
    return draw(form(content))


@st.composite
def cut(draw: DrawFn, content: bytes) -> bytes:
    """Bytes removed, and others put in their place, anywhere."""
    start = int(draw(st.floats(0, 1)) * len(content))
    gone = draw(st.sampled_from((0, 1, 3, 60, len(content))))
    return content[:start] + draw(st.sampled_from(PIECES) | st.binary(max_size=12)) + content[start + gone :]


@st.composite
def cells(draw: DrawFn, content: bytes) -> bytes:
    """A table with cells changed, and rows and columns lost, swapped or repeated."""
    rows = list(csv.reader(io.StringIO(content.decode("utf-8-sig"))))
    for _ in range(draw(st.integers(1, 3))):
        row = draw(st.integers(0, len(rows) - 1))
        column = draw(st.integers(0, max(0, len(rows[row]) - 1)))
        what = draw(st.sampled_from(("cell", "cell", "cell", "row", "column", "again", "longer")))
        if what == "row" and len(rows) > 1:
            del rows[row]
        elif what == "again":
            rows.insert(row, list(rows[row]))
        elif what == "longer":
            rows[row] = [*rows[row], draw(st.sampled_from(CELLS))]
        elif what == "column":
            rows = [[c for i, c in enumerate(r) if i != column] for r in rows]
        elif rows[row]:
            cell = draw(st.sampled_from(CELLS) | st.floats().map(repr) | st.text(max_size=6))
            rows[row] = [*rows[row][:column], cell, *rows[row][column + 1 :]]
    out = io.StringIO()
    csv.writer(out, lineterminator="\n").writerows(rows)
    return out.getvalue().encode("utf-8", "surrogatepass")


@st.composite
def document(draw: DrawFn, value: Any, odd: st.SearchStrategy[Any], keys: st.SearchStrategy[Any]) -> Any:
    """A document of mappings, lists and values, with some of them changed, lost, renamed or moved deeper."""
    value = copy.deepcopy(value)
    for _ in range(draw(st.integers(1, 3))):
        if not (all_places := list(places(value))):
            return draw(odd)
        holder, key = draw(st.sampled_from(all_places))
        what = draw(st.sampled_from(("put", "put", "put", "lose", "rename", "deeper")))
        if what == "put":
            holder[key] = draw(odd)
        elif what == "deeper":
            holder[key] = [holder[key]]
        elif what == "rename" and isinstance(holder, dict):
            holder[draw(keys)] = holder.pop(key)
        else:
            del holder[key]
    return value


def places(value: Any) -> Iterator[tuple[Any, Any]]:
    """Every holder and key within a document."""
    keys = list(value) if isinstance(value, dict) else range(len(value)) if isinstance(value, list) else ()
    for key in keys:
        yield value, key
        yield from places(value[key])


def of_yaml(content: bytes) -> st.SearchStrategy[bytes]:
    """A YAML file with its document changed."""
    return document(parse_yaml(content.decode(), ""), *OF_YAML).map(
        lambda value: yaml_text(value).encode("utf-8", "replace")
    )


def of_json(content: bytes) -> st.SearchStrategy[bytes]:
    """A JSON file with its document changed."""
    return document(json.loads(content), *OF_JSON).map(lambda value: json.dumps(value).encode())


def saved(content: bytes) -> st.SearchStrategy[bytes]:
    """A file of acf_jax.surrogate.saved with its header changed."""
    line, _, body = content.partition(b"\n")
    return of_json(line).map(lambda header: header + b"\n" + body)
