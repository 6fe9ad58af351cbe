"""Tables of any size: rows of text and columns of numbers are read alike, in bounded time and memory."""

import tracemalloc
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from impacts import write

from acf_jax.dataset import columns as long
from acf_jax.dataset import read_dataset
from acf_jax.dataset import table as module
from acf_jax.dataset.columns import read_columns
from acf_jax.dataset.table import read_table
from acf_jax.errors import InputError

COLUMNS = ("time_s", "force_n")
CELLS = st.sampled_from((
    "", " ", "1", " 2.5 ", "-3e-3", "010", "+.5", '"4"', "1e99",
    "x", "nan", "inf", "1e100", "1e400", "9" * 400, "1_0", "\u0967", "0x1F", '"1,5"', "true",
))  # fmt: skip


@given(
    st.lists(st.lists(CELLS, min_size=0, max_size=4), max_size=8),
    st.sampled_from(("time_s,force_n", "force_n,note,time_s", "time_s,force_n,,")),
)
def test_columns_of_numbers_are_those_of_the_rows(rows: list[list[str]], header: str) -> None:
    text = "\n".join([header, *(",".join(row) for row in rows), ""])
    path = Path("table.csv")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(module, "read_bytes", lambda _: text.encode())
        patch.setattr(long, "_BLOCK", 5)
        patch.setattr(long, "_CHUNK", 3)
        table, (lines, values) = read_columns(path, COLUMNS)
        expected = read_table(path, COLUMNS)
    numbers = [[expected.number(row, column) for column in COLUMNS] for row in expected.rows]
    assert sorted(table.faults) == sorted(expected.faults) and table.columns == expected.columns
    if not table.faults:
        assert lines.tolist() == [row.number for row in expected.rows] and values.tolist() == numbers


def test_a_long_trace_is_read_in_bounded_memory(tmp_path: Path) -> None:
    path, n = tmp_path / "trace.csv", 300_000
    time = np.arange(n) / 1e5
    path.write_text("time_s,force_n\n" + "".join(f"{t:.6f},0.000000\n" for t in time))
    tracemalloc.start()
    table, (lines, values) = read_columns(path, COLUMNS)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert not table.faults and lines[-1] == n + 1
    np.testing.assert_array_equal(values, np.c_[time.round(6), np.zeros(n)])
    assert peak < 80 * n + 20e6, "a row takes its text, its line and its numbers, and joining them once more"


def test_a_fault_far_into_a_long_trace_has_its_row(tmp_path: Path) -> None:
    folder = write(tmp_path / "set")
    path = folder / "traces/t001.csv"
    rows = ["time_s,force_n", *(f"{1e-5 * k:.6f},1" for k in range(-50_000, 50_000))]
    for row, wrong in ((70_001, "0.5,x"), (80_001, "0.5")):
        path.write_text("\n".join([*rows[: row - 1], wrong, *rows[row:]]))
        with pytest.raises(InputError, match=rf"t001\.csv row {row}: "):
            read_dataset(folder)
    rows[90_000] = rows[89_999]
    path.write_text("\n\n".join(rows))
    with pytest.raises(InputError, match=r"t001\.csv row 180001: time_s is 0\.39998 after 0\.39998"):
        read_dataset(folder)


MANY = 1_000_001


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        ("time_s,force_n\n" + "1," * MANY, "row 2: is longer than 1,000,000 characters; write a row a line"),
        ("a," * MANY, "row 1: is longer than 1,000,000 characters; write a row a line"),
        ("time_s,force_n\n1,2\n" + '"\n",' * MANY, "row 250003: is longer than 1,000,000 characters"),
        ("time_s,force_n\n" + "\0" * MANY, "row 2: is longer than 1,000,000 characters"),
        (",".join(f"c{k}" for k in range(1001)), "has more than 1,000 columns; remove those that are not needed"),
        ('time_s,force_n\n"' + "1" * 200_000 + '",2', "is not a CSV table (field larger than field limit"),
        ("time_s,force_n\n1,2\n\xff", "is not UTF-8 text (invalid start byte); save it as UTF-8"),
    ],
)  # fmt: skip
@pytest.mark.parametrize("read", [read_table, lambda *given: read_columns(*given)[0]])
def test_what_is_no_table_is_refused_where_it_begins(tmp_path, read, text, fault) -> None:
    path = tmp_path / "table.csv"
    path.write_bytes(text.encode("latin-1"))
    tracemalloc.start()
    table = read(path, COLUMNS)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert len(table.faults) == 1 and fault in table.faults[0]
    assert peak < 80e6


def test_too_many_cells_to_keep_as_text(tmp_path, monkeypatch) -> None:
    monkeypatch.setattr(module, "_MOST_CELLS", 100)
    (tmp_path / "table.csv").write_text("a,b\n" + "1,2\n" * 51)
    assert read_table(tmp_path / "table.csv", ("a",)).faults == [
        f"{tmp_path / 'table.csv'}: holds more than 100 cells; split it into several tables"
    ]


def test_too_many_rows(tmp_path, monkeypatch) -> None:
    monkeypatch.setattr(long, "_MOST_ROWS", 1000)
    (tmp_path / "table.csv").write_text("a,b\n" + "1,2\n" * 1001)
    assert read_columns(tmp_path / "table.csv", ("a",))[0].faults == [
        f"{tmp_path / 'table.csv'}: holds more than 1,000 rows; cut it to what is needed"
    ]


def test_of_many_faults_the_rest_is_not_looked_for(tmp_path) -> None:
    path = tmp_path / "table.csv"
    path.write_text("time_s,force_n\n" + "1,x\n" * 500_000)
    table, _ = read_columns(path, COLUMNS)
    shown = table.shown_faults()
    assert (
        len(shown) == 9
        and shown[0] == f"{path} row 2: force_n is 'x', not a number; give a number such as 1.5e-3"
    )
    assert (
        "at least" in shown[-1] and "more faults of this file are not shown; correct these first" in shown[-1]
    )


def test_more_trials_than_can_be_compared(tmp_path) -> None:
    folder = write(tmp_path / "set")
    rows = "".join(f"t{k},0.1,60,80\n" for k in range(10_001))
    (folder / "trials.csv").write_text("trial,contact_velocity_m_per_s,pretension_n,peak_force_n\n" + rows)
    with pytest.raises(InputError) as error:
        read_dataset(folder)
    assert error.value.faults == [f"{folder / 'trials.csv'}: lists 10,001 trials; give 10,000 at most"]


def test_a_row_is_named_by_the_line_where_it_begins(tmp_path):
    path = tmp_path / "table.csv"
    path.write_bytes(b'\xef\xbb\xbf\r\na,b\r\n\r\n"two\r\nlines",1\r\n,\r\n"x",2\r\n')
    assert [(row.number, row.cells["b"]) for row in read_table(path, ("a", "b")).rows] == [(4, "1"), (7, "2")]
