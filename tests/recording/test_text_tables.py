"""Text tables as programs write them: separator, header, units, time and encoding are found, every value is exact."""

import gzip
from collections.abc import Iterable, Sequence
from decimal import Decimal
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from acf_jax.cli.main import commands
from acf_jax.errors import InputError
from acf_jax.recording.choose import choose
from acf_jax.recording.mapping import Mapping, Source
from acf_jax.recording.opened import Opened
from acf_jax.recording.readers import open_recording
from acf_jax.recording.series import Series
from acf_jax.recording.session import read_session

STEP = 250_000  # ns
TIME = np.arange(40) * STEP  # ns
FORCE = np.round(np.random.default_rng(0).normal(0.0, 5.0, TIME.size), 6)
EPOCH = 1_700_000_000  # s


def seconds(ns: np.ndarray = TIME) -> list[str]:
    return [f"{t // 10**9}.{t % 10**9:09d}" for t in ns.tolist()]


def rows(separator: str = ",", times: Iterable[object] | None = None, comma: bool = False) -> list[str]:
    """Time, force and 0.1 m/s."""
    cells = zip(times or seconds(), map(repr, FORCE.tolist()), strict=True)
    lines = [separator.join((str(t), f, "0.1")) for t, f in cells]
    return [line.replace(".", ",") for line in lines] if comma else lines


def read(
    path: Path, lines: Sequence[str], force: str = "force", encoding: str = "utf-8", **stated: object
) -> Series:
    path.write_bytes(("\n".join(lines) + "\n").encode(encoding))
    recording = open_recording(path, Mapping.model_validate(stated))
    return recording.read({"force": Source(name=force)}, lambda *_: None)["force"]


def check(series: Series, begin: int = 0) -> None:
    """The force bit for bit, the times to the nanosecond."""
    assert np.array_equal(series.value, FORCE)
    assert np.array_equal(series.time, TIME + begin)


# the name of the time, and its unit in ns
NAMES = {
    "time": 10**9, "Time [ms]": 10**6, "Time (ms)": 10**6, "TIME_MS": 10**6, "timeMs": 10**6, "time [µs]": 1000,
    "t": 10**9, "t/s": 10**9, "t (s)": 10**9, "T": 10**9, "t_us": 1000, "Time Elapsed (s)": 10**9, "__time": 10**9,
    "Elapsed Time (sec)": 10**9, "relTime": 10**9, "TimeStamp": 10**9, "#time": 10**9, "date_time": 10**9,
    "Zeit [s]": 10**9, "Zeit in ms": 10**6, "Zeitstempel": 10**9, "Messzeit (ms)": 10**6,
    "Zeit  1 - Standardmessrate [s]": 10**9, "Temps": 10**9, "Horodatage (ms)": 10**6, "Tiempo": 10**9,
    "Tempo [s]": 10**9, "tijd_ms": 10**6, "Čas": 10**9, "czas [ms]": 10**6, "Время, мс": 10**6, "时间(s)": 10**9,
    "時間": 10**9, "시간 [ms]": 10**6, "X [s]": 10**9, "ms": 10**6, "seconds": 10**9, "X-Axis": 10**9,
    "Rel. time [min]": 60 * 10**9,
}  # fmt: skip


@pytest.mark.parametrize("name", NAMES)
def test_a_time_is_known_by_word_and_unit(name, tmp_path):
    cells = [f"{t / NAMES[name]:.12f}" for t in TIME.tolist()]
    lines = [f"{name};force;velocity", *rows(";", cells)]
    check(read(tmp_path / "log.csv", lines))


@pytest.mark.parametrize(
    ("header", "says"),
    [
        ("Wert,force,velocity", "'Wert': is taken for the time, as the only column that increases"),
        ("time zone,force,velocity", ""),  # it speaks of time, and increases
        ("T [°C],force,velocity", "is taken for the time"),  # by its values, not as t
    ],
)
def test_a_time_of_another_name_is_the_one_that_increases(header, says, tmp_path):
    series = read(tmp_path / "log.csv", [header, *rows()])
    check(series)
    assert says in " ".join(series.notes) and (says or not series.notes)


def test_times_of_two_names_are_told_apart_by_their_values(tmp_path):
    """A temperature T, a dead time and a counter do not increase by time."""
    lines = [f"{i},21.0,0.004,{row}" for i, row in enumerate(rows())]
    check(read(tmp_path / "log.csv", ["sample,T,dead time,time,force,velocity", *lines]))
    lines = [f"{row},{time}" for row, time in zip(rows(), seconds(), strict=True)]
    with pytest.raises(InputError, match="columns 'time', 'clock' may all be the time; name it by --time"):
        read(tmp_path / "log.csv", ["time,force,velocity,clock", *lines])
    with pytest.raises(
        InputError, match="columns 'time', 'clock' may all be the time"
    ):  # beside other faults
        choose([Opened(tmp_path / "log.csv", open_recording(tmp_path / "log.csv"), True)], Mapping())
    counts = [f"{i},{3 * i + 10**10},{row}" for i, row in enumerate(rows())]
    assert (
        read(tmp_path / "log.csv", ["n,ticks,time,force,velocity", *counts]).notes == ()
    )  # nothing of the ticks
    check(read(tmp_path / "log.csv", ["time,force,velocity,clock", *lines], time="clock"))


@pytest.mark.parametrize("unit", [1, 1000, 10**6])
def test_times_since_1970_tell_their_unit_by_their_size(unit, tmp_path):
    """`rostopic echo -p` writes ns: whole numbers that a float does not hold stay exact, in lines with words, too."""
    begin = EPOCH * 10**9
    cells = [Decimal(begin + t) / unit for t in TIME.tolist()]
    lines = ["%time,force,velocity", *rows(times=cells)]
    series = read(tmp_path / "log.csv", lines)
    check(series, begin)
    assert f"times of that size are read in units of {unit * 1e-9:g} s" in series.notes[0]
    worded = ["%time,force,velocity,frame", *(f"{row},ft" for row in rows(times=cells))]
    check(read(tmp_path / "log.csv", worded), begin)
    quoted = [*lines[:-1], lines[-1].replace(",0.1", ',"0.1"')]
    check(read(tmp_path / "log.csv", quoted), begin)


NOON = int(np.datetime64("2026-03-01T12:00:00", "ns").astype(int))
DAY = 86_400 * 10**9  # ns
# how dates are written of which a row may lack one where it lacks the signal, and the time of the first
DATES = {
    "ISO 8601": ("{y}-{m}-{d}T{t}", NOON),
    "a blank": ("{y}-{m}-{d} {t}", NOON),
    "decimal comma": ("{y}-{m}-{d} {t},", NOON),
    "Z": ("{y}-{m}-{d}T{t}Z", NOON),
    "UTC": ("{y}-{m}-{d} {t} UTC", NOON),
    "zone of none": ("{y}-{m}-{d}T{t}+00:00", NOON),
    "zone in the east": ("{y}-{m}-{d}T{t}+05:30", NOON - 5 * 3600 * 10**9 - 1800 * 10**9),
    "zone in the west": ("{y}-{m}-{d} {t}-0330", NOON + 3 * 3600 * 10**9 + 1800 * 10**9),
    "zone of hours": ("{y}-{m}-{d} {t}+01", NOON - 3600 * 10**9),
    "slashes, year first": ("{y}/{m}/{d} {t}", NOON),
    "slashes, of one digit": ("{y}/3/1 {t}", NOON),
    "dots, year first": ("{y}.{m}.{d} {t}", NOON),
    "German": ("{d}.{m}.{y} {t}", NOON),
    "German, a comma before the time": ("{d}.{m}.{y}, {t}", NOON),
    "German, of one digit": ("1.3.{y} {t},", NOON),
    "MATLAB": ("{d}-Mar-{y} {t}", NOON),
    "half of the day": ("{y}-{m}-{d} {t} PM", NOON),
    "time of day": ("{t}", NOON % DAY),
    "time of day, ends with ms": ("{c}", NOON % DAY),
    "time of day in America": ("{t} p.m.", NOON % DAY),
    "time of day in the morning": ("{t} am", 0),
    "minutes and seconds": ("{s}", 0),
}  # fmt: skip


@pytest.mark.parametrize("name", DATES)
def test_dates_and_times_of_day(name, tmp_path):
    """With decimal points or commas; times of day count from midnight."""
    form, begin = DATES[name]
    times = []
    for t in TIME.tolist():
        fraction = f"{t:09d}"
        of_day = f"12:00:00.{fraction}"
        text = form.format(
            y="2026", m="03", d="01", t=of_day, c=of_day.replace(".", ":"), s=f"00:00.{fraction}"
        )
        times.append(text.replace(".", ",").replace(",3,", ".3.").replace("01,03,2026", "01.03.2026")[:-1]
                     if text.endswith(",") else text)  # fmt: skip
    lines = rows(";", times)
    check(read(tmp_path / "log.csv", ["Zeitstempel;force;v", ";;0.1", *lines]), begin)


@pytest.mark.parametrize(
    "stamp",
    ["3/1/2026 10:00:00", "13/1/2026 10:00:00", "1.3.26 10:00:00", "2026-13-01 10:00:00", "25:00:00", "10:00:00 XM"],
)  # fmt: skip
def test_dates_that_may_be_others_are_refused(stamp, tmp_path):
    lines = rows(times=[stamp] * TIME.size)
    with pytest.raises(InputError) as refused:
        read(tmp_path / "log.csv", ["time,force,velocity", "2026-03-01 09:59:59,1,0.1", *lines])
    assert str(refused.value) == (
        f"{tmp_path}/log.csv row 3: time is '{stamp}', no date or time of day that means one thing only;"
        " write them as 2026-03-01T10:00:00.000, give seconds, or state --rate"
    )


def test_times_of_day_pass_midnight(tmp_path):
    """Also in a signal that is first seen after it, and from one block of lines to the next."""
    begin = DAY - 10 * STEP
    clock = [str(np.datetime64(int(t) % DAY, "ns"))[11:] for t in TIME + begin]
    check(read(tmp_path / "log.csv", ["time,force,velocity", *rows(times=clock)]), begin)
    late = [row if i > 20 else row[: row.rindex(",") + 1] for i, row in enumerate(rows(times=clock))]
    series = read(tmp_path / "log.csv", ["time,force,velocity", *late], "velocity")
    assert np.array_equal(series.time, TIME[21:] + begin)
    many = np.arange(60_000) * 10**9 + 12 * 3600 * 10**9  # of several blocks
    lines = [f"{str(np.datetime64(int(t) % DAY, 'ns'))[11:]},1" for t in many]
    assert np.array_equal(read(tmp_path / "log.csv", ["time,force", *lines]).time, many)
    back = [*clock[:20], *clock[15:35]]  # a clock that is set back a little is no midnight
    assert (np.diff(read(tmp_path / "log.csv", ["time,force,v", *rows(times=back)]).time) < 0).sum() == 1


MISSING = (
    "",
    "NaN",
    "nan",
    "N/A",
    "#N/A",
    "#NV",
    "#WERT!",
    "#DIV/0!",
    "-",
    "---",
    "null",
    "None",
    "-1.#IND",
    "1.#QNAN",
)


@pytest.mark.parametrize("word", MISSING)
def test_words_for_no_value_are_no_samples(word, tmp_path):
    """Wherever they stand: such a row is no comment, so it counts where a rate is stated."""
    lines = [
        "force,time,velocity",
        *(f"{f!r},{t},0.1" for t, f in zip(seconds(), FORCE.tolist(), strict=True)),
    ]
    for place in (1, 4):
        blank = [*lines]
        blank[place] = f"{word},{lines[place].split(',', 1)[1]}"
        series = read(tmp_path / "log.csv", blank)
        assert np.array_equal(series.time, np.delete(TIME, place - 1))
        assert np.array_equal(series.value, np.delete(FORCE, place - 1))
        by_rate = read(tmp_path / "log.csv", blank, sample_rate_hz=4000)
        assert np.array_equal(by_rate.time, series.time)


@pytest.mark.parametrize("word", ["OVERLOAD", "1.#INF", "n", "#5"])
def test_other_words_are_no_numbers(word, tmp_path):
    lines = ["time,force,velocity", *rows()]
    lines[5] = f"0.001,{word},0.1"
    with pytest.raises(InputError, match=rf"row 6: force is '{word}', not a number; correct the cell"):
        read(tmp_path / "log.csv", lines)


@pytest.mark.parametrize(
    "name", ["log.dat", "log.asc", "log.prn", "LOG.CSV", "log.log", "log.lvm", "log.dat.gz"]
)
def test_names_of_texts(name, tmp_path):
    content = "\n".join(["time force velocity", *rows(" ")]).encode()
    path = tmp_path / name
    path.write_bytes(gzip.compress(content) if name.endswith("gz") else content)
    check(open_recording(path).read({"force": Source(name="force")}, lambda *_: None)["force"])


@pytest.mark.parametrize("name", ["log.dat", "log.csv", "log.lvm"])
def test_what_is_no_text_is_refused(name, tmp_path):
    path = tmp_path / name
    np.savez(tmp_path / "a.npz", time=TIME, force=FORCE)
    path.write_bytes((tmp_path / "a.npz").read_bytes())
    with pytest.raises(
        InputError, match=r"holds no text; name it by its kind, such as \.mat or \.npz, or save it as"
    ):
        open_recording(path)
    path.write_bytes("\n".join(["time,force,v", *rows()[:9]]).encode() + b"\n" + bytes(4096))
    with pytest.raises(
        InputError, match="row 11: holds no text, as after a loss of power; cut the file off there"
    ):
        open_recording(path)


def stamped(head: str, row: str) -> list[str]:
    """Rows by a template: ns since the epoch, their seconds and the rest, a number and the force."""
    values = zip(TIME.tolist(), FORCE.tolist(), strict=True)
    late = 999 * 10**6  # so that seconds change on the way
    cells = [(i, EPOCH * 10**9 + late + t, f) for i, (t, f) in enumerate(values)]
    return [head, *(row.format(i=i, ns=ns, s=ns // 10**9, rest=ns % 10**9, f=repr(f)) for i, ns, f in cells)]


STAMPED = {
    "rostopic": (
        "%time,field.header.seq,field.header.stamp,field.wrench.force.z",
        "{s}000000000,{i},{ns},{f}",
    ),
    "stamp never set": ("%time,field.header.seq,field.header.stamp,field.wrench.force.z", "{ns},{i},0,{f}"),
    "secs and nsecs": ("field.header.stamp.secs,field.header.stamp.nsecs,force", "{s},{rest},{f}"),
    "sec and nanosec": ("/ft/header/stamp/sec,/ft/header/stamp/nanosec,/ft/wrench/force/z", "{s},{rest},{f}"),
    "rosbagTimestamp": ("rosbagTimestamp,header,stamp,secs,nsecs,frame_id,force,z", "{ns},,,0,0,ft,{f},0"),
    "bag to csv": ("rosbagTimestamp,header,stamp,secs,nsecs,frame_id,force,z", "{i},,,{s},{rest},ft,{f},0"),
}


@pytest.mark.parametrize("name", STAMPED)
def test_stamps_of_ros(name, tmp_path):
    """The stamp of the only message is its time unless it was never set; of several messages that of the log is."""
    head, row = STAMPED[name]
    force = next(name for name in head.split(",") if name.endswith(("force", "force.z", "force/z")))
    check(read(tmp_path / "log.csv", stamped(head, row), force), EPOCH * 10**9 + 999 * 10**6)


def test_the_time_of_several_topics_is_that_of_the_log(tmp_path):
    """As PlotJuggler writes them: every row is of one topic, and only `__time` stands in all of them."""
    head = "__time,/ft/header/stamp,/ft/force/z,/arm/header/stamp,/arm/v"
    lines = [f"{t},{t},{f!r},," for t, f in zip(seconds(), FORCE.tolist(), strict=True)]
    check(read(tmp_path / "log.csv", [head, *lines[:5], "0.0011,,,7.0,0.1", *lines[5:]], "/ft/force/z"))


def test_a_time_may_be_the_sum_of_columns(tmp_path):
    lines = stamped("a_sec,b_nsec,force", "{s},{rest},{f}")
    series = read(tmp_path / "log.csv", lines, time="a_sec + b_nsec")
    check(series, EPOCH * 10**9 + 999 * 10**6)


def test_a_time_before_each_signal(tmp_path):
    """As programs write signals of several rates: each has the time on its left."""
    lines = [
        f"{t};{f!r};{t + 1};0.1" for t, f in zip(seconds(), FORCE.tolist(), strict=True) for t in [float(t)]
    ]
    path = tmp_path / "log.csv"
    check(read(path, ["Time;force;Time;velocity", *lines]))
    both = open_recording(path).read({"v": Source(name="velocity")}, lambda *_: None)
    assert np.array_equal(both["v"].time - 10**9, TIME)


HEADERS = {
    "blanks": [" time  force   velocity", *rows("  ")],
    "blanks and decimal commas": ["time force velocity", *rows(" ", comma=True)],
    "columns of a width": [
        "     Time [s]   force     Speed [m/s]",
        *(f"{t:>13}{f:>16}{0.1:>8}" for t, f in zip(seconds(), FORCE, strict=True)),
    ],
    "semicolons, a name with commas": ["time;force, z, raw, N;velocity", *rows(";")],
    "commas, a quoted name with one": ['time,"force, z",velocity', *rows()],
    "tabs and decimal commas": ["time\tforce\tvelocity", *rows("\t", comma=True)],
    "decimal commas in quotes": [
        '"time","force","velocity"', *('"' + row.replace(";", '","') + '"' for row in rows(";", comma=True)),
    ],
    "bars": ["time|force|velocity", *rows("|")],
    "lines before": ["Device\tamplifier 1", "Rate\t4000", "", "time\tforce\tvelocity", *rows("\t")],
    "many lines before": [*(f"Key {i}: {i}" for i in range(120)), "time,force,velocity", *rows()],
    "DynoWare": [
        "File Name: \ttest.dwd", "Sampling rate [Hz]: \t4000", "Measuring time [s]: \t5", "Cycle No: \t1",
        "Time\tforce\tv", "s\tN\tm/s", *rows("\t"),
    ],
    "lines before, of as many cells": ["Device;amplifier;1a", "time;force;v", "s;N;m/s", *rows(";")],
    "numpy.savetxt": ["# time,force,velocity", *rows()],
    "numpy.savetxt, words apart by blanks": ["# time force velocity", *rows()],
    "stars": ["* time,force,velocity", *rows()],
    "stars before, and blanks": ["*** made by hand", "* time [s]  force  speed [m/s]", *rows("  ")],
    "signs of a comment and blanks": ["% time force velocity", *rows("\t")],
    "another separator than the rows": ["time;force;velocity", *rows()],
    "a comment before": ["# a, b, c", "time,force,velocity", *rows()],
    "a row of units": ["time,force,velocity", "s,N,m/s", *rows()],
    "units in brackets": ["time;force;velocity", "[s];[N];[m/s]", *rows(";", comma=True)],
    "units above the names": ["s,N,m/s", "time,force,velocity", *rows()],
    "units in ms above the names": ["ms;N;m/s", "time;force;v", *rows(";", [t / 1e6 for t in TIME.tolist()])],
    "units in ms": ["time,force,velocity", "ms,N,m/s", *rows(times=[t / 1e6 for t in TIME.tolist()])],
    "channels and units": ["time;force;v", "clock;MX840 1;MX840 2", "s;N;m/s", *rows(";")],
    "units and channels": ["time;force;v", "s;N;m/s", "clock;MX840 1;MX840 2", *rows(";")],
    "separators that end lines": ["time,force,velocity,", *(f"{row}," for row in rows())],
    "separators that end rows": ["time,force,velocity", *(f"{row}," for row in rows())],
    "empty lines": ["", "time,force,velocity", "", *rows()[:9], "", *rows()[9:], "", ""],
    "comments": ["time,force,velocity", *rows()[:9], "# paused, by, hand", *rows()[9:]],
    "names that are numbers": ["time,1,2", *rows()],
    "a name missing": [",force,velocity", *rows()],
    "words in the rows": ["time,force,velocity,state", *(f"{row},RUN" for row in rows())],
    "columns called the same": ["time,force,x,x", *(f"{row},1" for row in rows())],
}  # fmt: skip


@pytest.mark.parametrize("name", HEADERS)
def test_separator_and_header_agree_with_the_numbers(name, tmp_path):
    lines = HEADERS[name]
    force = {"semicolons, a name with commas": "force, z, raw, N", "commas, a quoted name with one": "force, z",
             "names that are numbers": "1"}.get(name, "force")  # fmt: skip
    series = read(tmp_path / "log.txt", lines, force)
    check(series)
    has_units = any(line.strip("[").startswith(("s,", "s;", "s]", "s\t", "ms,", "ms;")) for line in lines)
    assert ("is taken for a row of units: " in " ".join(series.notes)) == has_units


# header lines, what is stated, and what 1 there is in SI units of force, motion and pretension
SIGNALS = {
    "brackets": (["time,force [kN],v [mm/s],preload (lbf)"], {}, (1e3, 1e-3, 4.4482216152605)),
    "a row of units": (["time,force,v,preload", "s,mN,mm s^-1,kgf"], {}, (1e-3, 1e-3, 9.80665)),
    "a sign before": (["time,force [kN],v [mm/sec],preload [N]"], {"force": "-1*force [kN]"}, (-1e3, 1e-3, 1.0)),
    "a factor before": (["time,force [kN],v [mm/s],preload [bar]"],
                        {"force": "1*force [kN]", "velocity": "0.5*v [mm/s]", "pretension": "35*preload [bar]"},
                        (1.0, 0.5, 35.0)),
    "a position": (["time,force [N],z [mm],preload"], {"position": "z [mm]"}, (1.0, 1e-3, 1.0)),
    "no units": (["time,force [0],v (filtered),preload [N]"], {}, (1.0, 1.0, 1.0)),
}  # fmt: skip


@pytest.mark.parametrize("name", SIGNALS)
def test_signals_in_stated_units_are_in_si_units(name, tmp_path):
    lines, stated, factors = SIGNALS[name]
    if "position" not in stated:
        stated = {"velocity": lines[0].split(",")[2], **stated}
    (tmp_path / "log.csv").write_text("\n".join([*lines, *(f"{t},1,1,1" for t in seconds())]))
    session = read_session(tmp_path / "log.csv", Mapping.model_validate(stated))
    found = (session.force, session.speed, session.pretension)
    assert tuple(series.value[0] for series in found) == pytest.approx(factors)
    told = [note for note in session.notes if ": is read in " in note]
    assert len(told) == sum(abs(x) != 1.0 for x in factors) * (name != "a factor before")


def test_a_unit_of_something_else_is_refused(tmp_path):
    lines = ["time,force [V],v [mm],preload [bar]", *(f"{t},1,1,1" for t in seconds())]
    (tmp_path / "log.csv").write_text("\n".join(lines))
    with pytest.raises(InputError) as refused:
        read_session(tmp_path / "log.csv", Mapping.model_validate({"velocity": "v [mm]"}))
    assert [fault.removeprefix(f"{tmp_path}/log.csv ") for fault in refused.value.faults] == [
        "column 'force [V]': is in V, no unit of a force; put what one is in N before its name, as 0.1*NAME",
        "column 'v [mm]': is in mm, no unit of a velocity; put what one is in m/s before its name, as 0.1*NAME",
        "column 'preload [bar]': is in bar, no unit of a pretension; put what one is in N before its name, as 0.1*NAME",
    ]


def test_a_table_without_a_header_is_listed_by_number(tmp_path):
    check(read(tmp_path / "log.csv", rows(), "column 2"))
    with pytest.raises(
        InputError, match="its first line must name the columns, which are 'column 1' to 'column 3'"
    ):
        choose([Opened(tmp_path / "log.csv", open_recording(tmp_path / "log.csv"), True)], Mapping())


def test_a_blank_line_among_exact_times(tmp_path):
    lines = ["t_ns force velocity", *rows(" ", [EPOCH * 10**9 + t for t in TIME.tolist()])]
    check(read(tmp_path / "log.txt", [*lines[:9], "", *lines[9:], ""]), EPOCH * 10**9)


def test_a_comment_longer_than_a_cell_may_be(tmp_path):
    check(
        read(tmp_path / "log.csv", [f'# {{"settings": "{"x" * 200_000}"}}', "time,force,velocity", *rows()])
    )


def test_a_header_of_another_length_is_named(tmp_path):
    with pytest.raises(
        InputError, match="row 2 and others: has 3 cells, not 4 as the header; quote what holds a separator"
    ):
        read(tmp_path / "log.csv", ["time,force, z,velocity", *rows()])


@pytest.mark.parametrize("text", ["nan", "nan,nan\nnan,nan\n", "N/A;-\n"])
def test_a_table_of_nothing_but_missing_values_has_no_time(text, tmp_path):
    with pytest.raises(InputError, match=r"log\.csv"):
        read(tmp_path / "log.csv", text.splitlines())


def test_rows_of_another_length_are_told_together(tmp_path):
    lines = ["time,force,velocity", *rows()]
    for i in (4, 9, 11):
        lines[i] += ",5"
    lines[20] = lines[20][: lines[20].rindex(",")]
    with pytest.raises(InputError) as refused:
        read(tmp_path / "log.csv", lines)
    said = "quote what holds a separator, or correct the row: the file may be cut off"
    assert refused.value.faults == [
        f"{tmp_path}/log.csv row 5 and others: has 4 cells, not 3 as the header; {said}",
        f"{tmp_path}/log.csv row 21: has 2 cells, not 3 as the header; {said}",
    ]


def test_columns_called_the_same_are_told_apart(tmp_path):
    lines = ["time,force,force", *rows()]
    check(read(tmp_path / "log.csv", lines, "force (1)"))
    with pytest.raises(InputError, match=r"is there 2 times; name one of 'force \(1\)', 'force \(2\)'"):
        read(tmp_path / "log.csv", lines, "force")


ENCODINGS = ("utf-8", "utf-8-sig", "utf-16", "utf-32", "utf-16-le", "utf-16-be", "cp1252")


@pytest.mark.parametrize("encoding", ENCODINGS)
@pytest.mark.parametrize("ends", ["\n", "\r\n", "\r"])
@pytest.mark.parametrize("packed", [False, True])
def test_encodings_and_ends_of_lines(encoding, ends, packed, tmp_path):
    lines = ["Zeit;Kraft [N];Reibung µ", *rows(";", comma=True)]
    content = (ends.join(lines) + ends).encode(encoding)
    path = tmp_path / ("log.csv.gz" if packed else "log.csv")
    path.write_bytes(gzip.compress(content) if packed else content)
    recording = open_recording(path)
    assert [channel.name for channel in recording.channels()] == ["Zeit", "Kraft [N]", "Reibung µ"]
    series = recording.read({"force": recording.candidates("force")[0]}, lambda *_: None)["force"]
    check(series)
    assert ("is not UTF-8; read as Windows-1252" in "".join(series.notes)) == (encoding == "cp1252")


def test_a_rate_takes_the_place_of_times(tmp_path):
    lines = ["Sample,Fz", *(f"{i},{f!r}" for i, f in enumerate(FORCE.tolist()))]
    path = tmp_path / "log.csv"
    check(read(path, lines, "Fz", sample_rate_hz=4000))
    with pytest.raises(
        InputError, match=r"none alone increases; name it by --time, .* or state the sampling rate by"
    ):
        read(path, lines, "Fz")
    blank = [*lines[:5], "4,", *lines[6:]]  # a row without a value counts
    assert np.array_equal(read(path, blank, "Fz", sample_rate_hz=4000).time, np.delete(TIME, 4))
    alone = ["Fz", *map(repr, FORCE.tolist())]
    check(read(path, alone, "Fz", sample_rate_hz=4000))
    check(read(path, [line.replace(".", ",") for line in alone], "Fz", sample_rate_hz=4000))


def test_names_in_another_code_page_are_told(tmp_path):
    path = tmp_path / "log.csv"
    path.write_bytes("\n".join(["시간,힘,속도,예압", *(f"{row},40" for row in rows())]).encode("cp949"))
    with pytest.raises(InputError, match="is not UTF-8, and names may be misread; save it as UTF-8"):
        choose([Opened(path, open_recording(path), True)], Mapping())


def test_a_quotation_mark_that_is_not_closed(tmp_path):
    lines = ["time,force,velocity", *rows()]
    lines[6] = lines[6].replace(",", ',"', 1)
    with pytest.raises(
        InputError, match="row 7: its quotation marks do not go in pairs around cells; add or remove"
    ):
        read(tmp_path / "log.csv", lines)


def test_a_date_apart_from_its_time(tmp_path):
    clock = [str(np.datetime64(NOON + int(t), "ns")).replace("T", " ") for t in TIME]
    check(read(tmp_path / "log.txt", ["date time force velocity", *rows(" ", clock)]), NOON % DAY)
    with pytest.raises(InputError, match="row 2 and others: has 4 cells, not 3 as the header"):
        read(tmp_path / "log.txt", ["time force velocity", *rows(" ", clock)])
    us = [f"3/1/2026,{text[11:]}" for text in clock]  # a date that is not needed may be of any form
    check(read(tmp_path / "log.csv", ["Date,Time,force,velocity", *rows(",", us)]), NOON % DAY)


def run(*arguments: object) -> str:
    done = CliRunner().invoke(commands, ["import", *map(str, arguments)])
    return done.output if done.exit_code == 0 else str(done.exception)


def test_a_list_needs_nothing_else(tmp_path):
    path = tmp_path / "log.csv"
    path.write_text("\n".join(["a,b,b", "1,2,3", "1,2,3"]))
    assert run(path, "--list") == "  a      column\n  b (1)  column\n  b (2)  column\n"
    said = run(path, "--out", tmp_path / "set")  # all faults together
    for part in ("clearly the force", "clearly the velocity", "clearly the pretension", "is called a time"):
        assert part in said
    assert "--rate: must be greater than 0" in run(path, "--out", tmp_path / "set", "--rate", "-5")
    assert "time and sample_rate_hz are both given" in run(
        path, "--out", tmp_path / "set", "--rate", "4000", "--time", "a"
    )


def test_the_words_of_other_languages_name_signals(tmp_path):
    path = tmp_path / "log.csv"
    for head in (
        "Zeit [s];Kraft [N];Geschwindigkeit [m/s];Vorspannung [N]",
        "Temps (s);Force (N);Vitesse (m/s);Précharge (N)",
        "Tiempo;Fuerza;Velocidad;Precarga",
        "时间;力;速度;预紧力",
        "Czas [s];Siła [N];Prędkość [m/s];Napięcie wstępne [N]",
        "Tempo;Força;Velocidade;Pré-carga",
        "Zaman;Kuvvet;Hız;Ön yük",
        "Čas;Síla;Rychlost;Předpětí",
        "Idő;Erő;Sebesség;Előfeszítés",
        "time;load cell;speed;pre-load [N]",
    ):
        path.write_text("\n".join([head, *(f"{row};40" for row in rows(";"))]))
        chosen = choose([Opened(path, open_recording(path), True)], Mapping())
        assert [source.name for source in chosen.sources.values()] == head.split(";")[1:]
