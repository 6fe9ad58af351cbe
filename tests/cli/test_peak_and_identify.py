"""The commands `peak` and `identify`, as a user calls them."""

import json
import re
from pathlib import Path

import pytest
from click.testing import CliRunner

from acf_jax.cli.main import commands
from acf_jax.errors import InputError
from acf_jax.gap_model import write_model
from tests.corrected import gap_model

CONFIGS = Path(__file__).parents[2] / "configs"
RIG = ["--m", "4", "--d", "0", "--k-f", "0", "--k-c", "175561"]


@pytest.fixture
def run(monkeypatch, tmp_path):
    """Call a command; an `InputError` becomes the test's, anything else must have ended well."""
    monkeypatch.setattr("acf_jax.start.start_jax", lambda: None)  # tests set JAX themselves

    def call(*arguments: str) -> str:
        result = CliRunner().invoke(commands, [str(a) for a in arguments])
        if isinstance(result.exception, InputError):
            raise result.exception
        assert result.exit_code == 0, result.output
        return result.output

    return call


def test_peak_prints_table_1(run):
    velocities = [x for v in (0.05, 0.1, 0.2, 0.3, 0.35) for x in ("--v-e", str(v))]
    output = run("peak", "--rig", CONFIGS / "table1_rig.yaml", "--f-p", "100", *velocities)
    forces = [float(x) for x in re.findall(r"([\d.]+) N ", output)]
    assert [round(f) for f in forces] == [108, 130, 195, 271, 310]


def test_peak_as_json_with_an_option_in_place_of_the_file(run):
    arguments = (
        "peak",
        "--rig",
        CONFIGS / "table1_rig.yaml",
        "--d",
        "20",
        "--f-p",
        "100",
        "--v-e",
        "0.2",
        "--json",
    )
    document = json.loads(run(*arguments))
    assert document["rig"]["d"] == 20
    (row,) = document["peaks"]
    assert row["has_peak"] and 190 < row["f_max"] < 196 and 0 < row["t_max"] < 0.01


def test_peak_says_where_there_is_none(run):
    arguments = ("--m", "4", "--d", "1200", "--k-f", "9000", "--k-c", "2e4", "--v-e", "0.8", "--f-p", "50")
    assert "no peak" in run("peak", *arguments)
    row = json.loads(run("peak", *arguments, "--json"))["peaks"][0]
    assert row == {"v_e": 0.8, "f_max": None, "t_max": None, "has_peak": False}


def test_peak_plot_is_self_contained(run, tmp_path):
    plot = tmp_path / "force.html"
    run("peak", *RIG, "--v-e", "0.1", "--v-e", "0.3", "--f-p", "100", "--plot", plot)
    page = plot.read_text()
    assert "0.3 m" in page and "contact force" in page
    assert not re.search(r"<script[^>]+src=", page)


def test_peak_lists_all_faults_at_once(run):
    with pytest.raises(InputError) as caught:
        run("peak", "--m", "-4", "--d", "nan", "--v-e", "-0.1", "--plot", "force.pdf")
    faults = "\n".join(caught.value.faults)
    for part in ("--m must be", "--d must be", "--k-f is missing", "--k-c is missing", "--f-p is missing"):
        assert part in faults
    assert "--v-e must be" in faults and ".html" in faults


def test_peak_lists_the_faults_of_a_rig_file(run, tmp_path):
    rig = tmp_path / "rig.yaml"
    rig.write_text("rig: {m: heavy, d: 0, k_c: 1.0e5, mass: 4}\n")
    with pytest.raises(InputError) as caught:
        run("peak", "--rig", rig, "--v-e", "0.1", "--f-p", "10")
    faults = "\n".join(caught.value.faults)
    for part in ("rig.m: must be a number", "rig.k_f: is missing", "rig.mass: is not known"):
        assert part in faults


def test_a_rig_file_takes_every_spelling_of_a_number(run, tmp_path):
    rig = tmp_path / "rig.yaml"
    rig.write_text("rig: {m: 4e0, d: 0, k_f: +.0e1, k_c: 1.75561e5}\n")
    document = json.loads(run("peak", "--rig", rig, "--v-e", "0.1", "--f-p", "100", "--json"))
    assert document["rig"] == {"m": 4.0, "d": 0.0, "k_f": 0.0, "k_c": 175561.0}


def test_peak_refuses_what_is_in_another_unit(run, tmp_path):
    rig = tmp_path / "rig.yaml"
    rig.write_text("rig: {m: 4000, d: 0, k_f: 0, k_c: 175.561}\n")
    with pytest.raises(InputError) as caught:
        run("peak", "--rig", rig, "--k-f", "1e9", "--v-e", "200", "--f-p", "1e6")
    faults = "\n".join(caught.value.faults)
    for part in ("rig.m: must be at most 100 kg, but is 4000; if it is in g, divide by 1000", "--k-f must be at most",
                 "rig.k_c: must be at least 2000 N/m, but is 175.561; if it is in N/mm, multiply by 1000",
                 "--v-e must be at most 5 m/s, but is 200; if it is in mm/s", "--f-p must be at most"):  # fmt: skip
        assert part in faults
    assert "N " in run("peak", *RIG, "--v-e", "0", "--f-p", "0")


def test_peak_of_a_corrected_model_says_where_it_extrapolates(run):
    model = CONFIGS.parent / "examples/rig_model.json"
    asked = ("peak", "--model", model, "--f-p", "60", "--v-e")
    assert "v_e = 3 m/s lies outside the tried 0.05 to 0.35 m/s: the model extrapolates" in run(*asked, "3")
    assert json.loads(run(*asked, "0.2", "--json"))["notes"] == []


def test_identify_table_1(run):
    output = run("identify", CONFIGS / "table1.csv", "--rig", CONFIGS / "table1_rig.yaml")
    for part in ("3.37 %", "1.64 %", "1.90 %", "not at all", "force traces"):
        assert part in output
    document = json.loads(run("identify", CONFIGS / "table1.csv", "--json"))
    assert document["information"]["std_with_nothing_else_known"]["m"] is None


def test_identify_lists_all_faults_at_once(run, tmp_path):
    table = tmp_path / "trials.csv"
    table.write_text(
        "contact_velocity_m_per_s,pretension_n,peak_force_n\n0.1,100,fast\n-0.1,100,120\n0.1,100,0\n"
    )
    with pytest.raises(InputError) as caught:
        run("identify", table)
    faults = "\n".join(caught.value.faults)
    for part in ("row 2", "not a number", "row 3", "row 4", "peak_force_n must be at least 0.1 N, but is 0"):
        assert part in faults


@pytest.mark.parametrize(
    ("rows", "fault"),
    [
        (
            "50,100,110\n100,100,137",
            "contact_velocity_m_per_s must be at most 5 m/s, but is 50; if it is in mm/s",
        ),
        ("0.1,0.1,110\n0.2,0.1,137", "pretension_n is at most 0.1 N in all rows; if it is in kN"),
        ("0.1,100,110e3\n0.2,100,137e3", "row 2: peak_force_n must be at most 50000 N"),
        (
            "0.1,100,10\n0.3,100,182",
            "1 of 2 peaks lie below their pretension, the first of them row 2, 10 N at 100 N",
        ),
    ],
)
def test_identify_refuses_other_units_and_tared_peaks(rows, fault, run, tmp_path):
    table = tmp_path / "trials.csv"
    table.write_text(f"contact_velocity_m_per_s,pretension_n,peak_force_n\n{rows}\n")
    with pytest.raises(InputError) as caught:
        run("identify", table)
    assert all(str(table) in line for line in caught.value.faults) and fault in str(caught.value)


def test_identify_of_one_peak_says_what_is_not_known(run, tmp_path):
    table = tmp_path / "trials.csv"
    table.write_text("contact_velocity_m_per_s,pretension_n,peak_force_n\n0.2,100,195\n")
    output = run("identify", table)
    assert "nan" not in output and output.count("not known") == 6


def test_identify_takes_a_trial_at_rest(run, tmp_path):
    table = tmp_path / "trials.csv"
    table.write_text("contact_velocity_m_per_s,pretension_n,peak_force_n\n0,100,101\n0.2,100,195\n")
    assert "sqrt(k_C m) = 837." in run("identify", table)


def test_peak_draws_a_corrected_model(run, tmp_path):
    (tmp_path / "model.json").write_text(write_model(gap_model()))
    run(
        "peak",
        "--model",
        tmp_path / "model.json",
        "--f-p",
        "60",
        "--v-e",
        "0.2",
        "--plot",
        tmp_path / "force.html",
    )
    assert "v = 0.2 m/s" in (tmp_path / "force.html").read_text()
