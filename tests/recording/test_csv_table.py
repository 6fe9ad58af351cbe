"""Lines of nothing but numbers are read in blocks, all others cell by cell: the values are the same."""

from pathlib import Path

import numpy as np
import pytest

from acf_jax.errors import InputError
from acf_jax.recording.mapping import Mapping
from acf_jax.recording.readers import _text, csv_table

VALUES = np.random.default_rng(3).normal(size=(20, 3)) * [1.0, 1e-300, 1e17]


@pytest.fixture(autouse=True)
def small_chunks(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(_text, "BLOCK", 250)


def read(path: Path, lines: list[str], separator: str = ",") -> np.ndarray:
    path.write_text("\n".join(["# a rig", separator.join(("time", "force", "other")), *lines]) + "\n")
    chunks = list(csv_table.open_recording(path, Mapping()).chunks(["time", "other"], lambda *_: None))
    return np.concatenate([np.column_stack([c["time"], c["other"]]) for c in chunks])


@pytest.mark.parametrize("odd", [None, "blank cell", "quoted", "blank line", "trailing"])
@pytest.mark.parametrize("separator", [",", ";", "\t"])
def test_every_double_is_read_exactly(odd: str | None, separator: str, tmp_path: Path) -> None:
    lines = [separator.join(map(repr, row)) for row in VALUES.tolist()]
    if separator == ";":
        lines = [line.replace(".", ",") for line in lines]
    expected = VALUES[:, [0, 2]].copy()
    if odd == "blank cell":
        lines[9], expected[9] = separator.join(["0", "1", " "]), [0.0, np.nan]
    elif odd == "quoted":
        lines[9], expected[9] = separator.join(['"0"', '"1\n"', '"5"']), [0.0, 5.0]
    elif odd == "blank line":
        lines.insert(9, "")
    elif odd == "trailing":
        lines[9] += separator
    np.testing.assert_array_equal(read(tmp_path / "log.csv", lines, separator), expected)


@pytest.mark.parametrize(
    ("row", "says"), [("1,2,x", "other is 'x'"), ("1,2", "has 2 cells"), ("1,2,3,4", "has 4")]
)
def test_a_fault_names_its_row(row: str, says: str, tmp_path: Path) -> None:
    lines = [",".join(map(repr, values)) for values in VALUES.tolist()]
    with pytest.raises(InputError, match=f"row 14: {says}"):
        read(tmp_path / "log.csv", [*lines[:11], row, *lines[11:]])
