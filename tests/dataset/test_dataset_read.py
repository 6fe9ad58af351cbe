"""Reading a data set: what is accepted, and that each fault is named with file, place and remedy."""

import os
import re
import shutil
from pathlib import Path

import numpy as np
import pytest
from impacts import RIG, sampled, write

from acf_jax.dataset import GapDataset, Trace, data_sets, read_conditions, read_dataset
from acf_jax.dataset.units import time_fault
from acf_jax.errors import InputError


@pytest.fixture
def folder(tmp_path) -> Path:
    return write(tmp_path / "set")


def faults_of(folder) -> list[str]:
    with pytest.raises(InputError) as caught:
        read_dataset(folder)
    return caught.value.faults


def edit(path: Path, old: str, new: str) -> None:
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new, 1))


def scale(path: Path, column: int, factor: float) -> None:
    header, *rows = path.read_text().splitlines()
    cells = [row.split(",") for row in rows]
    for row in cells:
        row[column] = repr(float(row[column]) * factor)
    path.write_text("\n".join([header, *(",".join(row) for row in cells)]) + "\n")


def test_a_rig_may_repeat_without_scatter(folder):
    path = folder / "dataset.yaml"
    path.write_text(path.read_text() + "  contact_velocity_rel_std: 0\n  pretension_rel_std: 0.0\n")
    measurement = read_dataset(folder).measurement
    assert (measurement.contact_velocity_rel_std, measurement.pretension_rel_std) == (0.0, 0.0)


def test_a_spike_is_not_beyond_the_range(folder):
    edit(folder / "dataset.yaml", "force_noise_std_n: 1.0", "range_n: 300")
    plain = (folder / "traces" / "t001.csv").read_text()
    (folder / "traces" / "t001.csv").write_text(re.sub("(-0.002750,).*", r"\g<1>9999", plain))
    assert read_dataset(folder).measurement.range_n == 300.0


def test_reads_what_was_written(folder):
    dataset = read_dataset(folder)
    assert isinstance(dataset, GapDataset)
    np.testing.assert_array_equal(dataset.rig.values, [2.1, 60.0, 800.0, 3.4e5])
    np.testing.assert_array_equal(dataset.rig.stds, [0.04, 18.0, 500.0, 4e4])
    measurement = dataset.measurement
    assert measurement.force_noise_std_n == 1.0
    assert (measurement.contact_velocity_rel_std, measurement.pretension_rel_std) == (0.005, 0.005)
    assert [trial.name for trial in dataset.trials] == ["t000", "t001", "t002", "t003"]
    assert dataset.trials[1].condition == (0.1, 60.0)
    trace = dataset.trials[1].trace
    assert trace.time.dtype == trace.force.dtype == np.float64
    assert trace.time.shape == trace.force.shape == (136,)
    assert trace.time[0] == -0.003
    with pytest.raises(ValueError, match="read-only"):
        trace.force[0] = 0.0


def test_opens_nothing_but_what_is_listed(folder, monkeypatch):
    (folder / "answer.yaml").write_text("effects: [gravity]")
    (folder / "traces" / "unlisted.csv").write_text("not a trace")
    opened = []
    plain = Path.open
    monkeypatch.setattr(Path, "open", lambda self, *a, **k: opened.append(self.name) or plain(self, *a, **k))
    read_dataset(folder)
    assert sorted(opened) == ["dataset.yaml", "t000.csv", "t001.csv", "t002.csv", "t003.csv", "trials.csv"]


def test_spreadsheet_dialects_read_the_same(folder):
    plain = read_dataset(folder)
    for path in [folder / "dataset.yaml", folder / "trials.csv", *(folder / "traces").iterdir()]:
        rows = path.read_text().splitlines()
        if path.suffix == ".csv":
            rows = [",".join(f' "{cell}"'.strip() for cell in row.split(",")) + ",,," for row in rows]
            rows += ["", ",,,", ""]
        path.write_bytes(b"\xef\xbb\xbf" + "\r\n".join(rows).encode())
    again = read_dataset(folder)
    assert [t.condition for t in again.trials] == [t.condition for t in plain.trials]
    for one, other in zip(plain.trials, again.trials, strict=True):
        np.testing.assert_array_equal(one.trace.force, other.trace.force)


def test_other_columns_are_kept(folder):
    path = folder / "trials.csv"
    header, *rows = path.read_text().splitlines()
    path.write_text("\n".join([header + ",operator,", *(row + ',"Ada, L.",' for row in rows)]))
    assert read_dataset(folder).trials[2].other == {"operator": "Ada, L."}


def test_peaks_only_and_mixed(folder):
    shutil.rmtree(folder / "traces")
    edit(folder / "trials.csv", ",trace", ",was_trace")
    assert all(trial.trace is None and trial.peak_force for trial in read_dataset(folder).trials)


KG = "moving_mass_kg:             {value: 2.10, std: 0.04}"
K_C = "{value: 3.4e5, std: 4.0e4}"
DESCRIPTION_FAULTS = [
    ("schema: acf-gap-dataset/1", "schema: acf-gap-dataset/2", ": schema: must be 'acf-gap-dataset/1'"),
    ("schema: acf-gap-dataset/1\n", "", ": schema: is missing; add it"),
    ("description: made up", "description: [made, up]", ": description: must be text"),
    (
        "description: made up",
        "descripton: x",
        ": descripton: is not a known key; did you mean 'description'?",
    ),
    (KG, "moving_mas_kg: {value: 2.10, std: 0.04}", "did you mean 'moving_mass_kg'?"),
    (KG, "", ": rig.moving_mass_kg: is missing"),
    (
        KG,
        "moving_mass_kg: 2.1",
        ": rig.moving_mass_kg: has no standard deviation, which a diagnosis needs; write",
    ),
    (KG, "moving_mass_kg: [2.1, 0.04]", ": rig.moving_mass_kg: must hold `key: value` pairs"),
    ("std: 0.04}", "sd: 0.04}", ": rig.moving_mass_kg.sd: is not a known key; did you mean 'std'?"),
    ("std: 0.04}", "std: 0.0}", ": rig.moving_mass_kg.std: must be a number above 0"),
    ("std: 0.04}", "std: -0.04}", ": rig.moving_mass_kg.std: must be a number above 0"),
    ("std: 0.04}", "std: .inf}", ": rig.moving_mass_kg.std: must be a finite number"),
    ("std: 0.04}", "std: 1e6}", ": rig.moving_mass_kg.std: must be at most 100 kg"),
    ("value: 2.10", "value: two", ": rig.moving_mass_kg.value: must be a number"),
    ("value: 2.10", "value: .nan", ": rig.moving_mass_kg.value: must be a finite number"),
    ("value: 2.10", "value: yes", ": rig.moving_mass_kg.value: must be a number"),
    ("value: 2.10", "value: 2100.0", "if it is in g, divide by 1000"),
    ("value: 2.10", "value: -2.1", "must be at least 0.02 kg"),
    ("value: 60.0", "value: -60.0", "must be at least 0 N s/m"),
    (K_C, "{value: 340.0, std: 40.0}", "if it is in N/mm, multiply by 1000"),
    ("force_noise_std_n: 1.0", "force_noise_std_n: -1.0", ": measurement.force_noise_std_n"),
    ("force_noise_std_n: 1.0", "force_noise: 1.0", "did you mean 'force_noise_std_n'?"),
    ("force_noise_std_n: 1.0", "pretension_rel_std: 0.4", "if it is in percent, divide by 100"),
    (
        "force_noise_std_n: 1.0",
        "range_n: 0.5",
        "measurement.range_n: must be at least 1 N, but is 0.5; if it is in kN",
    ),
    (
        "force_noise_std_n: 1.0",
        "tool_mass_kg: 2.5",
        "measurement.tool_mass_kg: is 2.5 kg, more than all that moves (rig.moving_mass_kg is 2.1)",
    ),
    ("force_noise_std_n: 1.0", "tool_mass_kg: 1300", "measurement.tool_mass_kg: must be at most 100 kg"),
    ("force_noise_std_n: 1.0", "range_n: full", "measurement.range_n: must be a number"),
    ("force_noise_std_n: 1.0", "range_n: 70", "measurement.range_n: is 70 N, but trial 't003' reads 2"),
    (
        "force_noise_std_n: 1.0",
        "pretension_rel_std: -0.1",
        "must be at least 0, but is -0.1; give it as a share",
    ),
    ("rig:", "rig: [", "dataset.yaml line"),
    ("description: made up", "description: a\ndescription: b", "'description' is given twice"),
]


@pytest.mark.parametrize(("old", "new", "message"), DESCRIPTION_FAULTS)
def test_faults_of_the_description(folder, old, new, message):
    edit(folder / "dataset.yaml", old, new)
    faults = faults_of(folder)
    assert any(message in fault for fault in faults), faults
    assert all("dataset.yaml" in fault for fault in faults)


TRIAL_FAULTS = [
    ("pretension_n", "pretension", "column 'pretension_n' is missing; did you mean 'pretension'?"),
    ("contact_velocity_m_per_s,", "", "column 'contact_velocity_m_per_s' is missing"),
    ("peak_force_n,trace", "peak,path", "columns 'peak_force_n' and 'trace' are both missing"),
    ("peak_force_n,trace", "trace,trace", "column 'trace' is there twice"),
    ("t001,", "t000,", "row 3: trial 't000' is already in row 2"),
    ("t001,", ",", "row 3: trial is empty"),
    ("t001,0.1", "t001,fast", "row 3 (trial 't001'): contact_velocity_m_per_s is 'fast', not a number"),
    ("t001,0.1", "t001,", "row 3 (trial 't001'): contact_velocity_m_per_s is empty"),
    ("t001,0.1", "t001,nan", "contact_velocity_m_per_s is 'nan', not a finite number"),
    ("t001,0.1", "t001,1e999", "contact_velocity_m_per_s is '1e999', not a finite number"),
    ("t001,0.1", "t001,1_0", "contact_velocity_m_per_s is '1_0', not a"),
    ("t001,0.1", "t001,100", "if it is in mm/s, divide by 1000"),
    ("t001,0.1", "t001,-0.1", "contact_velocity_m_per_s must be at least"),
    ("t001,0.1", "t001,0", "contact_velocity_m_per_s must be at least"),
    ("t001,0.1,60.0", "t001,0.1,-60", "pretension_n must be at least 0 N"),
    ("t001,0.1,60.0", "t001,0.1,60000", "if it is in gf, multiply by 0.0098, if in mN, divide by 1000"),
    ("t001,0.1,60.0", 't001,"0,1",60.0', "contact_velocity_m_per_s is '0,1', not a number"),
    ("t001,0.1,60.0", "t001,0,1,60.0", "row 3: has 6 cells, not 5; write decimals with a point"),
    ("t001,0.1,60.0,", "t001,0.1,", "row 3: has 4 cells, not 5; fill the row"),
    ("t001,0.1,60.0,", 't001,0.1,60.0,"', "is not a CSV table"),
    ("traces/t001.csv", "../set/traces/t001.csv/../../../etc/passwd", "leaves the folder"),
    ("traces/t001.csv", "/etc/passwd", "leaves the folder"),
    ("traces/t001.csv", "traces/t007.csv", "t007.csv: no such file"),
    ("traces/t001.csv", "traces", "traces: is not an ordinary file"),
    ("traces/t001.csv", "traces/t000.csv", "row 3 (trial 't001'): trace is that of row 2 already"),
    ("traces/t001.csv", "x" * 3000, "row 3 (trial 't001'): trace 'xxx"),
    ("traces/t001.csv", "a\0b", "is not a path"),
]


@pytest.mark.parametrize(("old", "new", "message"), TRIAL_FAULTS)
def test_faults_of_the_trials(folder, old, new, message):
    edit(folder / "trials.csv", old, new)
    faults = faults_of(folder)
    assert any(message in fault for fault in faults), faults


def test_an_incomplete_data_set_is_one(tmp_path):
    for part in ("a/dataset.yaml", "b/trials.csv", "c/traces/t1.csv", "notes/readme.txt"):
        (tmp_path / part).parent.mkdir(parents=True)
        (tmp_path / part).touch()
    assert data_sets(tmp_path) == ["a", "b", "c"]
    with pytest.raises(InputError, match=r"b/dataset.yaml: no such file"):
        read_dataset(tmp_path / "b")


def test_few_trials(tmp_path):
    assert "lists 2 trials; a diagnosis needs at least 3" in faults_of(write(tmp_path / "set", count=2))[0]


def test_row_without_a_result(folder):
    path = folder / "trials.csv"
    rows = path.read_text().splitlines()
    rows[3] = "t002,0.2,60.0,,"
    path.write_text("\n".join(rows))
    assert faults_of(folder) == [
        f"{path} row 4 (trial 't002'): has neither peak_force_n nor trace; fill one, or remove the row"
    ]


@pytest.mark.parametrize(
    ("column", "factor", "message"),
    [
        (2, 1e-3, "pretension_n is at most 0.06 N in all rows; if it is in kN"),
        (3, 1e-3, "peak_force_n is about"),
        (3, 1e3, "peak_force_n is about"),
    ],
)
def test_units_of_a_whole_column(folder, column, factor, message):
    scale_rows = folder / "trials.csv"
    header, *rows = scale_rows.read_text().splitlines()
    cells = [row.split(",") for row in rows]
    for row in cells:
        row[column] = repr(float(row[column]) * factor)
    scale_rows.write_text("\n".join([header, *(",".join(row) for row in cells)]))
    assert any(message in fault for fault in faults_of(folder))


def test_peaks_must_be_above_zero(folder):
    trials = folder / "trials.csv"
    rows = trials.read_text().splitlines()
    rows[2], rows[3] = (
        re.sub(r"60.0,[^,]+", f"60.0,{peak}", row) for row, peak in zip(rows[2:4], (0, -90), strict=True)
    )
    trials.write_text("\n".join(rows))
    edit(folder / "dataset.yaml", "value: 60.0", "value: -60.0")
    of_description, *of_peaks = faults_of(folder)
    assert "dataset.yaml" in of_description
    assert of_peaks == [
        f"{trials} row 3 (trial 't001'): peak_force_n must be above 0 N, but is 0; leave the cell empty where the"
        " peak is unknown",
        f"{trials} row 4 (trial 't002'): peak_force_n must be above 0 N, but is -90; force counts positive in"
        " compression: change the sign, or take off what the unloaded sensor reads",
    ]


def test_peaks_of_the_wrong_sign(folder):
    scale(folder / "trials.csv", 3, -1.0)
    faults = faults_of(folder)
    assert len(faults) == 4 and all("peak_force_n must be above 0 N" in fault for fault in faults)
    assert all("positive in compression" in fault for fault in faults)


def test_traces_of_the_wrong_sign(folder):
    """All or most of them; a single one is a faulty trial."""
    traces = sorted((folder / "traces").glob("*.csv"))
    scale(traces[0], 1, -1.0)
    assert read_dataset(folder)
    for trace in traces[1:]:
        scale(trace, 1, -1.0)
    (fault,) = faults_of(folder)
    assert fault.startswith(f"{folder / 'trials.csv'}: force_n falls in contact, to -")
    assert f"in {len(traces)} of {len(traces)} traces" in fault and "change the sign" in fault


@pytest.mark.parametrize(
    ("column", "factor", "message"),
    [
        (0, 1e3, "if it is in ms, divide by 1000"),
        (0, 1e6, "if it is in ms, divide by 1000"),
        (0, 1e-3, "if it is in ks, multiply by 1000"),
        (0, 1e-30, "long before the impact is over"),
        (1, 1e-3, "if in kN, multiply by 1000"),
        (1, 1e3, "if in mN, divide by 1000"),
    ],
)
def test_units_of_a_trace(folder, column, factor, message):
    scale(folder / "traces/t002.csv", column, factor)
    (fault,) = faults_of(folder)
    assert "t002.csv" in fault and message in fault


@pytest.mark.parametrize("rate", [51_200.0, 100_000.0, 200_000.0])
def test_times_in_ms_of_a_fast_sensor(rate):
    """A few ms a sample are possible in seconds, but no impact rises for so long."""
    trace = sampled(0.1, 60.0, np.random.default_rng(0), rate=rate)
    assert time_fault(trace, RIG.impact_time) is None
    fault = time_fault(Trace(1e3 * trace.time, trace.force), RIG.impact_time)
    assert fault is not None and "the force rises for" in fault and "if it is in ms, divide by 1000" in fault


@pytest.mark.parametrize("v", [0.05, 0.35])
def test_a_slow_sensor_is_not_taken_for_a_fast_one_in_ms(v):
    for seed in range(20):
        trace = sampled(v, 60.0, np.random.default_rng(seed), rate=100.0, end=2.0)
        assert time_fault(trace, RIG.impact_time) is None


def _swap(text: str) -> str:
    rows = text.splitlines()
    rows[9], rows[10] = rows[10], rows[9]
    return "\n".join(rows)


TRACE_FAULTS = [
    (lambda text: "", "t002.csv: is empty; its first line must be time_s,force_n"),
    (lambda text: "time_s,force_n\n\n", "t002.csv: holds no samples"),
    (lambda text: "time_s,force_n\n0,1\n", "t002.csv: holds 1 samples"),
    (lambda text: text.replace("force_n", "force"), "column 'force_n' is missing; did you mean 'force'?"),
    (lambda text: text.replace(",", ";"), "column 'time_s' is missing; separate cells by commas"),
    (_swap, "t002.csv row 11: time_s is"),
    (lambda text: text.replace("-0.002750", "-0.002875"), "time must increase from row to row"),
    (lambda text: text.replace("-0.002750,", "-0.002750,nan "), "t002.csv row 4: force_n is 'nan"),
    (lambda text: re.sub("(-0.002750,).*", r"\g<1>1e300", text), "larger than any measurement"),
    (lambda text: text.replace("-0.002750", "inf"), "t002.csv row 4: time_s is 'inf', not a finite number"),
    (lambda text: text[: text.index("-0.002750") + 5], "row 4: has 1 cells, not 2; fill the row"),
    (lambda text: "\n".join(text.splitlines()[:20]), "misses the impact that starts at 0"),
    (lambda text: "\n".join(text.splitlines()[:27]), "fewer than 3 samples from time 0 on"),
]


@pytest.mark.parametrize(("change", "message"), TRACE_FAULTS)
def test_faults_of_a_trace(folder, change, message):
    path = folder / "traces/t002.csv"
    path.write_text(change(path.read_text()))
    faults = faults_of(folder)
    assert any(message in fault for fault in faults), faults
    assert all("t002.csv" in fault for fault in faults)


def test_binary_and_foreign_encodings(folder):
    (folder / "traces/t000.csv").write_bytes(bytes(range(256)) * 100)
    (folder / "traces/t001.csv").write_bytes("time_s,force_n\n0,1\n".encode("utf-16"))
    (folder / "trials.csv").write_bytes((folder / "trials.csv").read_bytes() + b"\n")
    faults = faults_of(folder)
    assert len(faults) == 2 and all("is not UTF-8 text" in fault for fault in faults)


def test_files_that_are_too_large(folder, monkeypatch):
    monkeypatch.setattr("acf_jax.files.MAX_BYTES", 1000)
    (fault,) = [fault for fault in faults_of(folder) if "is larger than" in fault]
    assert "t000.csv" in fault and " and 1 more: is larger than" in fault


def test_a_link_does_not_leave_the_folder(folder, tmp_path):
    outside = tmp_path / "secret.csv"
    shutil.move(folder / "traces/t001.csv", outside)
    os.symlink(outside, folder / "traces/t001.csv")
    assert any("leaves the folder" in fault for fault in faults_of(folder))
    (folder / "traces/t001.csv").unlink()
    os.symlink("t001.csv", folder / "traces/t001.csv")
    assert faults_of(folder)


def test_missing_files(tmp_path, folder):
    assert "no such folder" in faults_of(tmp_path / "none")[0]
    for name in ("dataset.yaml", "trials.csv"):
        (folder / name).unlink()
    faults = faults_of(folder)
    assert len(faults) == 2 and all("no such file" in fault for fault in faults)


def test_all_faults_are_listed_together(folder):
    edit(folder / "dataset.yaml", "value: 60.0", "value: -60.0")
    edit(folder / "trials.csv", "t001,0.1", "t001,100")
    edit(folder / "traces/t000.csv", "-0.002750", "x")
    scale(folder / "traces/t002.csv", 0, 1e3)
    (folder / "traces/t003.csv").unlink()
    faults = faults_of(folder)
    assert [Path(fault.split()[0].rstrip(":")).name for fault in faults] == [
        "dataset.yaml",
        "trials.csv",
        "t000.csv",
        "t002.csv",
        "t003.csv",
    ]


def test_a_thousand_faults_of_one_file_stay_readable(folder):
    path = folder / "traces/t000.csv"
    path.write_text("time_s,force_n\n" + "x,y\n" * 1000)
    faults = faults_of(folder)
    assert len(faults) < 12 and "more faults of this file are not shown" in faults[-1]


def test_conditions_to_predict(tmp_path):
    path = tmp_path / "conditions.csv"
    path.write_text("trial,contact_velocity_m_per_s,pretension_n\nh 0-a.1,0.2,0\nh1,0.3,50\n")
    assert [(t.name, *t.condition) for t in read_conditions(path)] == [
        ("h 0-a.1", 0.2, 0.0),
        ("h1", 0.3, 50.0),
    ]


@pytest.mark.parametrize(
    ("rows", "message"),
    [
        ("", "has no rows"),
        ("a,0.2,50\na,0.3,50", "row 3: trial 'a' is already in row 2"),
        ("a,0.2,50\nA,0.3,50", "is already in row 2"),
        ("../a,0.2,50", "trial '../a' cannot name a file"),
        (".,0.2,50", "trial '.' cannot name a file"),
        ("a/b,0.2,50", "cannot name a file"),
        ("a\0b,0.2,50", "cannot name a file"),
        (f"{'a' * 300},0.2,50", "cannot name a file"),
        ("a,200,50", "if it is in mm/s, divide by 1000"),
        ("a,0.2,-1", "pretension_n must be at least 0 N"),
        ("a,0.2,0.05", "if it is in kN"),
        ("a,0.2", "has 2 cells, not 3"),
        ("a,nan,x", "not a finite number"),
    ],
)
def test_faults_of_conditions(tmp_path, rows, message):
    path = tmp_path / "conditions.csv"
    path.write_text("trial,contact_velocity_m_per_s,pretension_n\n" + rows)
    with pytest.raises(InputError) as caught:
        read_conditions(path)
    assert any(message in fault and "conditions.csv" in fault for fault in caught.value.faults)
