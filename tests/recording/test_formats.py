"""Files as MATLAB, LabVIEW, Excel, HDF5 and Parquet hold them, written by their libraries: every value comes back."""

import sys
from datetime import datetime, time, timedelta
from pathlib import Path

import numpy as np
import pytest
from needs import need_module

from acf_jax.errors import InputError
from acf_jax.recording import read_session
from acf_jax.recording.choose import choose
from acf_jax.recording.mapping import Mapping, Source
from acf_jax.recording.opened import Opened
from acf_jax.recording.readers import Recording, open_recording
from acf_jax.recording.series import Series

STEP = 250_000  # ns
TIME = np.arange(40) * STEP  # ns
SECONDS = 1e-9 * TIME
FORCE = np.round(np.random.default_rng(0).normal(0.0, 5.0, TIME.size), 12)  # Excel keeps 15 digits
SPEED = np.full(TIME.size, 0.1)


def read(recording: Recording, name: str = "force", time: str | None = None) -> Series:
    return recording.read({"a": Source(name=name, time=time)}, lambda *_: None)["a"]


def names(recording: Recording) -> list[str]:
    return [channel.name for channel in recording.channels()]


def check(series: Series, begin: int = 0, value: np.ndarray = FORCE, within: int = 0) -> None:
    """Values bit for bit, times to the nanosecond."""
    assert np.array_equal(series.value, value) and np.abs(series.time - TIME - begin).max() <= within


@pytest.mark.parametrize("packed", [False, True])
def test_matlab_arrays_and_structs(packed, tmp_path):
    """Rows or columns are vectors, a matrix is as many columns as it is narrow, a struct holds fields."""
    from scipy.io import savemat

    path = tmp_path / "log.mat"
    other = {"remark": "a rig", "cells": np.array([1, "x"], object), "one": 1.0, "cube": np.zeros((2, 3, 4))}
    struct = {"time": SECONDS, "signals": {"values": FORCE[:, None], "label": "Fz"}}
    arrays = {
        "t_ms": 1e3 * SECONDS[:, None],
        "force": FORCE,
        "F": np.c_[SPEED, FORCE],
        "G": np.c_[SPEED, FORCE].T,
    }
    savemat(path, {**other, **arrays, "out": struct}, do_compression=packed)
    recording = open_recording(path)
    for name in ("force", "F[1]", "G[1]"):
        check(read(recording, name))
    check(read(recording, "out.signals.values", "out.time"))
    assert names(recording) == ["one", "cube", "t_ms", "force", "F[0]", "F[1]", "G[0]", "G[1]",
                                "out.time", "out.signals.values"]  # fmt: skip
    with pytest.raises(
        InputError, match=r"the arrays 't_ms' \(40,\), 'one' \(1,\) must be of one dimension and length"
    ):
        read(recording, "one")


def opaque() -> bytes:
    """A variable of MATLAB's class 17, as a timetable is stored."""

    def element(kind: int, content: bytes) -> bytes:
        return np.array([kind, len(content)], "<u4").tobytes() + content + bytes(-len(content) % 8)

    flags = element(6, np.array([17, 0], "<u4").tobytes())
    matrix = element(6, np.array([13, 0], "<u4").tobytes()) + element(5, np.array([1, 1], "<i4").tobytes())
    content = flags + element(1, b"TT") + element(1, b"MCOS") + element(1, b"timetable")
    return element(14, content + element(14, matrix + element(1, b"") + element(6, bytes(4))))


def test_a_timetable_is_named(tmp_path):
    """Alone, or beside arrays that do not tell what is what."""
    from scipy.io import savemat

    path = tmp_path / "log.mat"
    savemat(path, {})
    path.write_bytes(path.read_bytes() + opaque())
    with pytest.raises(
        InputError, match=r"which only MATLAB reads; save its columns as vectors: time = seconds\("
    ):
        open_recording(path)
    savemat(path, {"force": FORCE})
    path.write_bytes(path.read_bytes() + opaque())
    recording = open_recording(path)
    assert names(recording) == ["force"]
    with pytest.raises(InputError, match="which only MATLAB reads"):
        choose([Opened(path, recording, True)], Mapping())


def as_matlab_73(path: Path) -> None:
    """As MATLAB writes it: HDF5 behind a block of 512 bytes, vectors as (1, N), classes as attributes."""
    h5py = need_module("h5py", "pip install 'acf-jax[mat]'")
    with h5py.File(path, "w", userblock_size=512) as file:
        for name, values in (("t", SECONDS), ("run/force", FORCE)):
            data = file.create_dataset(name, data=values[None, :], chunks=(1, 16), compression="gzip")
            data.attrs["MATLAB_class"] = np.bytes_("double")
        text = file.create_dataset("remark", data=np.array([[97], [98]], "u2"))
        text.attrs["MATLAB_class"] = np.bytes_("char")
        hidden = file.create_dataset("TT", data=np.zeros((1, 6), "u4"))
        hidden.attrs.update({"MATLAB_class": np.bytes_("timetable"), "MATLAB_object_decode": np.int32(3)})
        file.create_dataset("#refs#/a", data=np.zeros(3))
    content = bytearray(path.read_bytes())
    content[:512] = b"MATLAB 7.3 MAT-file".ljust(124) + b"\0\2IM" + bytes(384)
    path.write_bytes(content)


def test_matlab_73(tmp_path):
    as_matlab_73(tmp_path / "log.mat")
    recording = open_recording(tmp_path / "log.mat")
    assert names(recording) == ["run/force", "t"]
    check(read(recording, "run/force"))
    with pytest.raises(InputError, match="a table, timetable or object, which only MATLAB reads"):
        choose([Opened(tmp_path / "log.mat", recording, True)], Mapping(force="TT"))


def test_hdf5(tmp_path):
    """Groups with times of their own, a unit as an attribute, named fields, whole numbers."""
    h5py = need_module("h5py", "pip install 'acf-jax[hdf5]'")
    path = tmp_path / "log.h5"
    table = np.zeros(40, [("stamp_ns", "i8"), ("load", "f8")])
    table["stamp_ns"], table["load"] = TIME + 10**18 + 1, FORCE
    with h5py.File(path, "w") as file:
        file["ft/time"], file["ft/wrench"] = 1e3 * SECONDS, np.c_[SPEED, FORCE]
        file["ft/time"].attrs["units"] = "ms"
        file["arm/time"], file["arm/velocity"] = SECONDS[::2] + 1.0, SPEED[::2]
        file["table"], file["words"] = table, np.array([b"a", b"b"])
        file["elsewhere"] = h5py.ExternalLink("/etc/passwd", "/x")
    recording = open_recording(path)
    assert names(recording) == ["arm/time", "arm/velocity", "ft/time", "ft/wrench[0]", "ft/wrench[1]",
                                "table/stamp_ns", "table/load"]  # fmt: skip
    check(read(recording, "ft/wrench[1]", "ft/time"))
    check(read(recording, "table/load", "table/stamp_ns"), begin=10**18 + 1)
    with h5py.File(path, "a") as file:
        file["ft/time"].attrs["units"] = np.array([b"ms"])  # as some programs write it
    check(read(open_recording(path), "ft/wrench[1]", "ft/time"))
    with h5py.File(path, "a") as file:
        del file["table"]
    recording = open_recording(path)
    check(read(recording, "ft/wrench[1]"))  # by the time of its group
    assert np.array_equal(read(recording, "arm/velocity").time, TIME[::2] + 10**9)


def test_hdf5_never_leaves_its_file(tmp_path):
    h5py = need_module("h5py", "pip install 'acf-jax[hdf5]'")
    FORCE.tofile(tmp_path / "raw")
    with h5py.File(tmp_path / "log.h5", "w") as file:
        file["time"] = SECONDS
        file.create_dataset(
            "force", FORCE.shape, "f8", external=[(str(tmp_path / "raw"), 0, h5py.h5f.UNLIMITED)]
        )
        layout = h5py.VirtualLayout(FORCE.shape, "f8")
        layout[:] = h5py.VirtualSource(str(tmp_path / "other.h5"), "force", FORCE.shape)
        file.create_virtual_dataset("velocity", layout)
    recording = open_recording(tmp_path / "log.h5")
    for name in ("force", "velocity"):
        with pytest.raises(InputError, match=f"{name} is kept in another file; copy it into this one"):
            read(recording, name)


LVM = """\
LabVIEW Measurement{s}
Writer_Version{s}2
Separator{s}{word}
Decimal_Separator{s}{d}
X_Columns{s}{columns}
Date{s}2026/03/01
***End_of_Header***{s}
{s}
Channels{s}2{s}{s}
Samples{s}40{s}40{s}
Y_Unit_Label{s}Newton{s}m/s{s}
X0{s}{zero}{s}{zero}{s}
Delta_X{s}2{d}5E-4{s}2{d}5E-4{s}
***End_of_Header***{s}{s}
"""


def lvm(columns: str, separator: str = "\t", comma: bool = False, comment: bool = True) -> str:
    mark = "," if comma else "."
    word = "Tab" if separator == "\t" else "Comma"
    text = LVM.format(s=separator, d=mark, word=word, columns=columns, zero="0,0" if comma else "0.0")
    times = [f"{t:.6f}" for t in SECONDS]
    if columns == "Multi":
        head = "X_Value,force,X_Value,speed"
        cells = [[t, repr(f), t, "0.1"] for t, f in zip(times, FORCE.tolist(), strict=True)]
    else:
        head = "X_Value,force,speed"
        cells = [
            [t if columns == "One" else "", repr(f), "0.1"]
            for t, f in zip(times, FORCE.tolist(), strict=True)
        ]
    lines = [separator.join(row).replace(".", mark) for row in cells]
    if comment:
        head, lines[0] = f"{head},Comment", f"{lines[0]}{separator}begun by hand"
    return text + "\n".join([head.replace(",", separator), *lines]) + "\n"


@pytest.mark.parametrize("name", ["log.lvm", "log.txt", "log.csv"])
@pytest.mark.parametrize("columns", ["One", "Multi", "No"])
@pytest.mark.parametrize(
    "form",
    [{}, {"comma": True}, {"separator": ","}, {"comment": False}],
    ids=["tabs", "decimal commas", "commas", "no comment"],
)
def test_labview_text(name, columns, form, tmp_path):
    """By its content, whatever it is called; times of X_Value, or of X0 and Delta_X where there are none."""
    (tmp_path / name).write_text(lvm(columns, **form))
    recording = open_recording(tmp_path / name)
    check(read(recording))
    check(read(recording, "speed"), value=SPEED)


def test_labview_text_of_several_measurements(tmp_path):
    text = lvm("One")
    (tmp_path / "log.lvm").write_text(text + text[text.index("Channels") :])
    with pytest.raises(InputError, match="holds several measurements; save each in a file of its own"):
        read(open_recording(tmp_path / "log.lvm"))
    (tmp_path / "log.lvm").write_text(text[: text.index("***End")])
    with pytest.raises(
        InputError, match=r"has no line \*\*\*End_of_Header\*\*\* with data after it; save it"
    ):
        open_recording(tmp_path / "log.lvm")


def write_tdms(path: Path, channels: list[tuple[str, str, np.ndarray, dict]]) -> Recording:
    nptdms = need_module("nptdms", "pip install 'acf-jax[tdms]'")
    with nptdms.TdmsWriter(path) as writer:
        for part in (slice(0, 16), slice(16, None)):
            segment = [
                nptdms.ChannelObject(group, name, v[part], properties=p) for group, name, v, p in channels
            ]
            writer.write_segment(segment)
    return open_recording(path)


def test_tdms_with_sampling_intervals(tmp_path):
    """Each channel has its own; starts count where all are known."""
    begin = np.datetime64("2026-03-01T10:00:00", "us")
    fast = {"wf_increment": 2.5e-4, "wf_start_offset": 0.0, "wf_start_time": begin}
    slow = {"wf_increment": 5e-4, "wf_start_offset": 1.0, "wf_start_time": begin}
    recording = write_tdms(
        tmp_path / "log.tdms", [("ft", "force", FORCE, fast), ("arm", "speed", SPEED[::2].astype("f4"), slow)]
    )
    start = int(begin.astype("datetime64[ns]").astype(int))
    both = recording.read({k: Source(name=k) for k in ("ft/force", "arm/speed")}, lambda *_: None)
    check(both["ft/force"], begin=start)
    assert np.array_equal(both["arm/speed"].time, TIME[::2] + start + 10**9)


def test_tdms_without_sampling_intervals(tmp_path):
    """A channel of times, of dates, or a rate."""
    dates = np.datetime64("2026-03-01T10:00:00", "us") + (TIME // 1000).astype("m8[us]")
    recording = write_tdms(
        tmp_path / "log.tdms",
        [("a", "Zeit [ms]", 1e3 * SECONDS, {}), ("a", "force", FORCE, {}), ("a", "date", dates, {})],
    )
    assert names(recording) == ["Zeit [ms]", "force", "date"]
    check(read(recording))
    check(read(recording, time="date"), begin=int(dates[0].astype("datetime64[ns]").astype(int)), within=1)
    recording = write_tdms(tmp_path / "log.tdms", [("a", "force", FORCE, {}), ("a", "n", np.zeros(3), {})])
    with pytest.raises(InputError, match="no column is called a time, and none alone increases"):
        read(recording)
    check(read(open_recording(tmp_path / "log.tdms", Mapping(sample_rate_hz=4000))))
    with pytest.raises(InputError, match="the channels 'n' 3, 'force' 40 must be of one length"):
        read(recording, time="n")


def test_tdms_that_was_not_closed(tmp_path, capfd):
    write_tdms(tmp_path / "log.tdms", [("a", "t", SECONDS, {}), ("a", "force", FORCE, {})])
    content = (tmp_path / "log.tdms").read_bytes()
    (tmp_path / "log.tdms").write_bytes(content[:-16])
    series = read(open_recording(tmp_path / "log.tdms"))
    assert series.notes == (f"{tmp_path / 'log.tdms'}: was not closed; its last samples are missing",)
    assert np.array_equal(series.value, FORCE[: series.value.size]) and capfd.readouterr() == ("", "")


def write_xlsx(path: Path, sheets: dict[str, list[list[object]]]) -> Recording:
    openpyxl = need_module("openpyxl", "pip install 'acf-jax[excel]'")
    book = openpyxl.Workbook()
    book.remove(book.active)
    for title, rows in sheets.items():
        sheet = book.create_sheet(title)
        for row in rows:
            sheet.append(row)
    book.save(path)
    return open_recording(path)


def rows(times: list[object]) -> list[list[object]]:
    return [[t, f, None] for t, f in zip(times, FORCE.tolist(), strict=True)]


def test_excel(tmp_path):
    """Lines before the header, a row of units, sheets of text, numbers that are text."""
    about = [["Device", "amplifier 1"], ["Rate", 4000], []]
    table = [*about, ["Zeit", "Kraft", "Bemerkung"], ["ms", "N"], *rows((1e3 * SECONDS).tolist())]
    recording = write_xlsx(tmp_path / "log.xlsx", {"Notes": [["made by"], ["hand"]], "Data": table})
    assert names(recording) == ["Zeit", "Kraft", "Bemerkung"]
    series = read(recording, "Kraft")
    check(series)
    assert "sheet 'Data' row 5: is taken for a row of units" in series.notes[0]
    text = [["time", "force"], *([str(t).replace(".", ","), str(f)] for t, f, _ in rows(SECONDS.tolist()))]
    check(read(write_xlsx(tmp_path / "log.xlsx", {"Data": text})))


def test_excel_of_several_sheets(tmp_path):
    two = {
        "ft": [["time", "force"], *rows(SECONDS.tolist())],
        "arm": [["time", "speed"], [0.5, 0.1], [1.5, 0.2]],
    }
    recording = write_xlsx(tmp_path / "log.xlsx", two)
    assert names(recording) == ["ft/time", "ft/force", "arm/time", "arm/speed"]
    check(read(recording, "ft/force"))
    assert read(recording, "arm/speed").time.tolist() == [500_000_000, 1_500_000_000]
    with pytest.raises(InputError, match="'ft/time', 'arm/speed' are on several sheets"):
        read(recording, "arm/speed", "ft/time")


@pytest.mark.parametrize("first", [datetime(2026, 3, 1, 10), time(10)])
def test_excel_dates(first, tmp_path):
    """Which Excel keeps to the millisecond."""
    day = datetime(2026, 3, 1, 10)
    times = [day + timedelta(milliseconds=5 * i) for i in range(40)]
    cells = times if isinstance(first, datetime) else [t.time() for t in times]
    series = read(write_xlsx(tmp_path / "log.xlsx", {"Data": [["Zeit", "force"], *rows(cells)]}))
    assert np.abs(np.diff(series.time) - 5_000_000).max() < 1_000_001 and np.array_equal(series.value, FORCE)
    origin = int(np.datetime64(day, "ns").astype(int)) if isinstance(first, datetime) else 36_000 * 10**9
    assert abs(int(series.time[0]) - origin) < 1_000_000


def test_excel_of_old(tmp_path):
    (tmp_path / "log.xls").write_bytes(b"\xd0\xcf\x11\xe0")
    with pytest.raises(
        InputError, match=r"is of a kind that is not read; open it in Excel and save it as \.xlsx"
    ):
        open_recording(tmp_path / "log.xls")


def test_exact_times_of_which_one_is_missing_are_named(tmp_path):
    parquet = need_module("pyarrow.parquet", "pip install 'acf-jax[parquet]'")
    import pyarrow

    columns = {"time": [10**18 + 1, None, 10**18 + 3], "force": [0.0, 1.0, 2.0]}
    parquet.write_table(pyarrow.table(columns), tmp_path / "log.parquet")
    with pytest.raises(InputError, match="column 'time': lacks a value beside whole numbers"):
        open_recording(tmp_path / "log.parquet").read({"force": Source(name="force")}, lambda *_: None)


def test_parquet_columns_called_the_same(tmp_path):
    parquet = need_module("pyarrow.parquet", "pip install 'acf-jax[parquet]'")
    import pyarrow

    columns = [pyarrow.array(values) for values in (SPEED, SECONDS, FORCE, SPEED)]
    parquet.write_table(pyarrow.table(columns, names=["x", "time", "force", "x"]), tmp_path / "log.parquet")
    recording = open_recording(tmp_path / "log.parquet")
    assert names(recording) == ["x (1)", "time", "force", "x (2)"]
    check(read(recording))
    check(read(recording, "x (2)"), value=SPEED)


def test_numpy_matrices(tmp_path):
    np.savez(tmp_path / "log.npz", t=SECONDS, wrench=np.c_[SPEED, FORCE])
    check(read(open_recording(tmp_path / "log.npz"), "wrench[1]"))


@pytest.mark.parametrize(
    ("name", "module", "extra"),
    [("log.h5", "h5py", "hdf5"), ("log.tdms", "nptdms", "tdms"), ("log.xlsx", "openpyxl", "excel"),
     ("log.mat", "h5py", "mat")],
)  # fmt: skip
def test_a_missing_extra_is_named(name, module, extra, tmp_path, monkeypatch):
    (tmp_path / name).write_bytes(b"\x89HDF\r\n\x1a\n")
    monkeypatch.setitem(sys.modules, module, None)
    with pytest.raises(
        InputError, match=rf"needs {module}, which is not installed; pip install 'acf-jax\[{extra}\]'"
    ):
        open_recording(tmp_path / name)


@pytest.mark.parametrize(
    "name", ["log.mat", "log.h5", "log.tdms", "log.xlsx", "log.lvm", "log.csv.gz", "log.npz"]
)
@pytest.mark.parametrize(
    "content", [b"", b"PK\3\4", b"\x89HDF\r\n\x1a\n" + bytes(99), b"TDSm" + bytes(99), b"\x1f\x8b"]
)
def test_files_that_are_none(name, content, tmp_path):
    (tmp_path / name).write_bytes(content)
    with pytest.raises(InputError) as caught:
        read_session(tmp_path / name, Mapping())
    assert all(";" in fault for fault in caught.value.faults)
