"""The commands `design`, `speed` and `check`, as a user calls them."""

import csv
import json
import re
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result

from acf_jax.cli.main import commands, main
from acf_jax.errors import InputError, merged
from acf_jax.gap_model import Proposed, write_model
from tests.corrected import gap_model

CONFIGS = Path(__file__).parents[2] / "configs"
RIG = str(CONFIGS / "check_rig.yaml")
SURROGATE = CONFIGS.parent / "examples/rig_surrogate.eqx"
PALM = ("--body-area", "palm", "--contact", "transient", "--v-e", "0.2", "--f-p", "60")


@pytest.fixture
def call(monkeypatch):
    """The result of a command; an `InputError` becomes the test's."""
    monkeypatch.setattr("acf_jax.start.start_jax", lambda: None)  # tests set JAX themselves

    def invoke(*arguments: object) -> Result:
        result = CliRunner().invoke(commands, [str(a) for a in arguments])
        if result.exception is not None and not isinstance(result.exception, SystemExit):
            raise result.exception
        return result

    return invoke


def faults(call, *arguments: object) -> str:
    with pytest.raises(InputError) as caught:
        call(*arguments)
    return "\n".join(caught.value.faults)


def test_speed_is_the_papers_inverse(call):
    result = call(
        "speed", "--model", CONFIGS / "table1_rig.yaml", "--f-p", "100", "--limit", "250", "--limit", "90"
    )
    v = np.sqrt((250**2 - 100**2) / (4 * 175561))
    assert result.exit_code == 1 and f"{np.floor(v * 1e4) / 1e4:.4f} m/s" in result.output
    assert "none: pressing without speed takes 100 N already" in result.output
    kept = call("speed", "--model", CONFIGS / "table1_rig.yaml", "--f-p", "100", "--limit", "250")
    assert kept.exit_code == 0 and kept.output.splitlines()[1].endswith("1.0000    no stop within 1 s needed")


def test_a_rigs_file_is_called_rig_in_every_command_that_takes_one(call):
    asked = ("speed", "--f-p", "100", "--limit", "250", "--rig")
    assert call(*asked, CONFIGS / "table1_rig.yaml").output.count("250 N") == 1
    checked = (
        "check",
        "--body-area",
        "palm",
        "--contact",
        "transient",
        "--v-e",
        "0.2",
        "--f-p",
        "60",
        "--rig",
    )
    assert call(*checked, CONFIGS / "check_rig.yaml").output.startswith("Allowed")


def test_a_diagnosis_is_named_by_its_folder_or_its_model_and_a_data_set_is_none(call, tmp_path):
    path = tmp_path / "model.json"
    path.write_text(write_model(gap_model()))
    told = "--conditions", CONFIGS / "conditions_example.csv", "--out"
    forces = {call("predict", m, *told, tmp_path / "out").output for m in (path, tmp_path)}
    assert len(forces) == 1 and "2 impacts by the" in forces.pop()
    for command in (("predict", *told), ("train", "--out")):
        said = faults(call, command[0], CONFIGS.parent / "examples/rig", *command[1:], tmp_path / "other")
        assert "is a data set without a diagnosis" in said
    assert not (tmp_path / "other").exists()


def test_a_slower_contact_is_found_for_a_high_probability(call):
    asked = ("speed", "--model", RIG, "--f-p", "60", "--limit", "100", "--json", "--probability")
    speeds = [json.loads(call(*asked, p).output)["speeds"][0]["v_e"] for p in ("0.999", "0.9999")]
    assert 0.9 * speeds[0] < speeds[1] < speeds[0]


@pytest.mark.parametrize(
    "verdict, note",
    [("unknown", "fitted freely"), ("identified", "")],
)
def test_what_the_verdict_of_a_diagnosis_takes_from_an_answer(call, tmp_path, verdict, note):
    path = tmp_path / "model.json"
    path.write_text(write_model(gap_model().model_copy(update={"verdict": verdict})))
    speed = call("speed", "--model", path, "--f-p", "60", "--limit", "120")
    peak = call("peak", "--model", path, "--f-p", "60", "--v-e", "0.2")
    for output in (speed.output, peak.output):
        assert ("note: the diagnosis" in output) == bool(note) and note in output


PROPOSED = Proposed(contact_velocity_m_per_s=0.4375, pretension_n=90.0, repeats=3)


@pytest.mark.parametrize("change, says", [
    (
        {"lack": "separation", "next_experiment": PROPOSED},
        "its trials leave too many explanations standing; add 3 trials at 0.438 m/s and 90 N, then diagnose again",
    ),
    ({"lack": "traces"}, "its trials hold peaks and no force traces; record force traces, at 5 kHz or faster"),
    ({"lack": "detection"}, "most effects would not have shown in its trials; add trials at other speeds"),
    ({}, "its trials could not have told what causes the gap; add trials at other speeds"),
])  # fmt: skip
@pytest.mark.parametrize("command", ["speed", "design", "train"])
def test_nothing_is_built_on_a_diagnosis_with_too_little_data(
    command, change, says, monkeypatch, capsys, tmp_path
):
    folder = tmp_path / "diagnosis"
    folder.mkdir()
    poor = gap_model().model_copy(update={"verdict": "insufficient_data"} | change)
    (folder / "model.json").write_text(write_model(poor))
    (tmp_path / "design.yaml").write_text(
        "model: diagnosis\ngoal: fastest\nlimit: 110\nf_p: 70\nv_e: {low: 0.1, high: 0.3}\n"
    )
    arguments = {
        "speed": ["--model", folder, "--f-p", 70, "--limit", 110],
        "design": ["--config", tmp_path / "design.yaml", "--plot", tmp_path / "out.html"],
        "train": [folder, "--out", tmp_path / "out"],
    }[command]
    monkeypatch.setattr("acf_jax.start.start_jax", lambda: None)
    before = sorted(tmp_path.rglob("*"))
    with pytest.raises(SystemExit) as end:
        main([command, *map(str, arguments)])
    told = capsys.readouterr()
    assert end.value.code == 1 and not told.out and len(told.err.splitlines()) == 1
    assert "diagnosis/model.json: the diagnosis had too little data to answer: " in told.err
    assert told.err.startswith("no answer: ") and says in told.err
    assert sorted(tmp_path.rglob("*")) == before


def test_too_few_draws_of_a_simulated_model_are_refused(call, tmp_path):
    model, config = tmp_path / "model.json", tmp_path / "design.yaml"
    model.write_text(write_model(gap_model()))
    found = faults(call, "speed", "--model", model, "--f-p", 70, "--limit", 110, "--probability", 0.999)
    assert "--draws: a probability of 0.999 needs at least 20000 draws" in found
    config.write_text(
        "model: model.json\ngoal: fastest\nlimit: 110\nf_p: 70\nv_e: {low: 0.1, high: 0.3}\ndraws: 256\n"
    )
    assert "draws: a probability of 0.95 needs at least 400 draws" in faults(
        call, "design", "--config", config
    )


def test_design_in_words_as_json_and_as_a_picture(call, tmp_path):
    plot = tmp_path / "design.html"
    config = tmp_path / "design.yaml"
    text = (CONFIGS / "design.yaml").read_text().replace("table1_rig.yaml", str(CONFIGS / "table1_rig.yaml"))
    config.write_text(text + "starts: 4\ndraws: 1024\n")
    words = call("design", "--config", config, "--plot", plot)
    assert words.exit_code == 0
    for part in ("f_p      80 N (low end", "k_c", "N of margin", "0 are allowed and better"):
        assert part in words.output
    document = json.loads(call("design", "--config", config, "--json").output)
    assert document["feasible"] and document["force_not_exceeded_n"] <= 250
    assert document["optimum"]["f_p"] == 80 and document["search"]["scanned_better"] == 0
    page = plot.read_text()
    assert "optimum" in page and "limit 250 N" in page and not re.search(r"<script[^>]+src=", page)


def test_infeasible_design_ends_with_1_and_remedies(call, tmp_path):
    config = tmp_path / "design.yaml"
    config.write_text(
        f"model: {CONFIGS / 'table1_rig.yaml'}\ngoal: widest_margin\nlimit: 150\nv_e: 0.2\n"
        "f_p: {low: 80, high: 120}\n"
    )
    plot = tmp_path / "design.html"
    result = call("design", "--config", config, "--plot", plot)
    assert result.exit_code == 1 and "least loaded" in plot.read_text()
    for part in ("Not feasible", "None of 4,096", "raise limit from 150", "lower v_e from 0.2", "lower k_c"):
        assert part in result.output
    assert json.loads(call("design", "--config", config, "--json").output)["feasible"] is False


def test_design_lists_all_faults_at_once(call, tmp_path):
    config = tmp_path / "design.yaml"
    config.write_text("model: no.yaml\ngoal: slowest\nlimit: -3\nf_p: {low: 3, high: 1}\nv_e: fast\nfre: 2\n")
    found = faults(call, "design", "--config", config, "--plot", "design.pdf")
    for part in (
        "goal:",
        "limit:",
        "f_p: low (3) must be below high (1)",
        "v_e: must be a number",
        "fre: is not a known key; did you mean 'free'?",
    ):
        assert part in found
    assert ".html" in found and found.count("design.yaml") == 5
    config.write_text("model: no.yaml\ngoal: fastest\nlimit: 3\nf_p: 3\nv_e: 0.2\nrelative_std: {m: 2}\n")
    found = faults(call, "design", "--config", config)
    assert "goal: fastest needs v_e to be free" in found and "relative_std.m" in found and "no.yaml" in found
    config.write_text(
        f"model: {RIG}\ngoal: fastest\nlimit: true\nf_p: -3\nv_e: {{low: 0, high: 1}}\n"
        "free: {mass: {low: 1, high: 2}, k_c: {low: 0, high: 1e5}, v_e: {low: 0, high: x}}\n"
        "relative_std: {q: 0.1, m: 3}\n"
    )
    found = faults(call, "design", "--config", config)
    for part in (
        "limit: must be a number, but is True",
        "f_p: must be greater than or equal to 0, but is -3",
        "free.mass: is not a parameter of the model; known are m, d, k_f, k_c",
        "free.k_c: low must be above 0",
        "free.v_e: give its range at the key v_e",
        "free.v_e.high:",
        "relative_std.q: is not a quantity",
        "relative_std.m: must lie between 0 and 0.5",
    ):
        assert part in found


@pytest.mark.long
def test_where_a_surrogates_range_ends_is_no_missing_peak(call, tmp_path):
    def asked(text: str, rig: object = CONFIGS / "table1_rig.yaml") -> Path:
        config = tmp_path / "design.yaml"
        config.write_text(f"model: {rig}\nsurrogate: shipped\ngoal: fastest\nlimit: 5000\n{text}\n")
        return config

    found = faults(call, "design", "--config", asked("f_p: 600\nv_e: {low: 0.01, high: 3}"))
    assert "v_e: 0.01 to 3 leaves the surrogate's 0.01 to 1; narrow it" in found
    assert "f_p: 600 lies outside the surrogate's 0 to 500; leave out `surrogate`" in found
    heavy = tmp_path / "heavy.yaml"
    heavy.write_text("rig: {m: 12, d: 9000, k_f: 0, k_c: 1.0e+5}\n")
    found = faults(call, "design", "--config", asked("f_p: 100\nv_e: {low: 0.01, high: 1}", heavy))
    assert "m: 12 lies outside" in found and "zeta: 4.10792 lies outside the surrogate's 0 to 1.5" in found
    words = call("design", "--config", asked("f_p: 100\nv_e: {low: 0.01, high: 1}"))
    assert words.exit_code == 0 and "the surrogate's range ends there" in words.output
    speed = call("speed", "--model", SURROGATE, "--f-p", 60, "--limit", 500, "--up-to", 2)
    assert "limit not reached: the surrogate's range ends" in speed.output
    assert "outside the surrogate's range of 0.05 to 0.35 m/s" in speed.output


def test_what_is_in_another_unit_is_refused(call, tmp_path):
    config = tmp_path / "design.yaml"
    config.write_text(
        f"model: {CONFIGS / 'table1_rig.yaml'}\ngoal: fastest\nlimit: 0.25\nf_p: 1.0e+4\n"
        "v_e: {low: 10, high: 1000}\nfree: {k_c: {low: 80, high: 300}, m: {low: 1, high: 4000}, d: {low: 2, high: 1}}\n"
    )
    found = faults(call, "design", "--config", config)
    for part in ("limit: must be at least 1 N, but is 0.25; if it is in kN", "f_p: must be at most 5000 N",
                 "v_e: low must be at most 5 m/s, but is 10; if it is in mm/s",
                 "free.k_c: low must be at least 2000 N/m, but is 80; if it is in N/mm",
                 "free.m: high must be at most 100 kg, but is 4000", "low (2) must be below"):  # fmt: skip
        assert part in found
    found = faults(call, "speed", "--model", RIG, "--f-p", 1e4, "--limit", 0.1, "--up-to", 50)
    assert all(part in found for part in ("--f-p must be", "if it is in kN", "if it is in mm/s"))


def test_an_effect_is_freed_within_what_it_can_be(call, tmp_path):
    model, config = tmp_path / "model.json", tmp_path / "design.yaml"
    model.write_text(write_model(gap_model(("end_stop",), (0.5, 0.1))))
    config.write_text(
        "model: model.json\ngoal: fastest\nlimit: 120\nf_p: 60\nv_e: {low: 0.05, high: 0.3}\n"
        "free: {end_stop.share: {low: 0, high: 3}}\n"
    )
    found = faults(call, "design", "--config", config)
    assert "free.end_stop.share: 0 to 3 leaves what it can be, 0 to 1; narrow it" in found


def test_check_of_one_contact(call):
    result = call("check", "--model", RIG, *PALM, "--robot-mass-kg", "21.735", "--payload-kg", "6.86")
    assert result.exit_code == 0
    for part in (
        "Allowed: Palm",
        "limit 280 N",
        "not decided: no contact area",
        "v_max = 1.34 m/s",
        "series",
        "replace",
    ):
        assert part in result.output
    face = call("check", "--model", RIG, "--body-area", "face", *PALM[2:])
    assert face.exit_code == 1 and "Not allowed" in face.output and "not permissible" in face.output
    document = json.loads(call("check", "--model", RIG, *PALM, "--contact-area-cm2", "2", "--json").output)
    assert document["verdict"] == "allowed" and document["pressure_verdict"] == "allowed"
    assert "does not replace a measurement" in document["statement"] and document["assumptions"]


@pytest.mark.long
def test_check_of_a_table_names_the_first_offending_row(call, tmp_path):
    out = tmp_path / "verdicts.csv"
    result = call("check", "--model", RIG, "--situations", CONFIGS / "situations.csv", "--out", out)
    assert result.exit_code == 1
    assert "row 6, 'stoop', Masticatory muscle" in result.output
    asked = list(csv.DictReader((CONFIGS / "situations.csv").read_text().splitlines()))
    found = list(csv.DictReader(out.read_text().splitlines()))
    assert [{k: row[k] for k in asked[0]} for row in found] == asked
    assert [row["verdict"] for row in found] == ["allowed"] * 4 + ["not allowed"]
    assert [row["pressure_verdict"] for row in found][2] == "not decided"
    assert [row["decided_body_area"] for row in found][2:] == [
        "Sternum",
        "Deltoid muscle",
        "Masticatory muscle",
    ]
    assert "All rows take for granted that" in result.output and "no sensor's reading" in result.output
    again = tmp_path / "again.csv"
    call("check", "--model", RIG, "--situations", out, "--out", again)
    assert again.read_text() == out.read_text()
    blank = tmp_path / "blank.csv"
    blank.write_text("\n" + (CONFIGS / "situations.csv").read_text())
    call("check", "--model", RIG, "--situations", blank, "--out", out)
    assert list(csv.DictReader(out.read_text().splitlines())) == found
    rig = tmp_path / "untried.yaml"
    rig.write_text("rig: {m: 1.9, d: 60, k_f: 800, k_c: 60000}\n")
    result = call("check", "--model", rig, "--situations", blank, "--out", out)
    found = list(csv.DictReader(out.read_text().splitlines()))
    assert "caution: range unknown" in result.output
    assert ["range unknown" in row["cautions"] for row in found] == [True] * 4 + [False]


def test_check_with_a_corrected_model_and_own_limits(call, tmp_path):
    model, limits = tmp_path / "model.json", tmp_path / "limits.csv"
    model.write_text(write_model(gap_model()))
    limits.write_text(
        "body_region,specific_location,quasi_static_force_n,quasi_static_pressure_n_cm2,transient_force_factor,"
        "transient_pressure_factor,spring_constant_n_mm,effective_mass_kg\nHands and fingers,Glove,100,,2,2,40,0.6\n"
    )
    glove = (
        "--limits",
        limits,
        "--body-area",
        "glove",
        "--contact",
        "transient",
        "--f-p",
        "70",
        "--stop-after",
        "0.03",
    )
    document = json.loads(call("check", "--model", model, *glove, "--v-e", "0.2", "--json").output)
    assert document["verdict"] == "allowed" and document["force_limit_n"] == 200
    assert document["decided_by"] == "simulation" and document["pressure_verdict"] == "not decided"
    beyond = call("check", "--model", model, *glove, "--v-e", "0.6")
    assert beyond.exit_code == 1 and "never allowed by extrapolation" in beyond.output


def test_check_lists_all_faults_at_once(call, tmp_path):
    found = faults(
        call, "check", "--model", "no.json", "--body-area", "plam", "--contact", "transient", "--v-e", "nan",
        "--payload-kg", "3", "--confidence", "2", "--out", "x.csv",
    )  # fmt: skip
    for part in ("no.json: no such file", "--body-area 'plam'", "did you mean", "--v-e must be", "--f-p is missing",
                 "belong together", "--confidence", "--out belongs"):  # fmt: skip
        assert part in found
    table = tmp_path / "situations.csv"
    table.write_text(
        "situation,body_area,contact,contact_velocity_m_per_s,pretension_n,contact_area_cm2\n"
        "a,palm,hard,0.1,20,\nb,elbw,transient,-0.1,x,0\n"
    )
    found = faults(call, "check", "--model", RIG, "--situations", table)
    for part in ("--out is missing", "row 2", "contact is 'hard'", "row 3", "'elbw'", "zero or positive",
                 "not a number", "contact_area_cm2 must be positive"):  # fmt: skip
        assert part in found
    rig = tmp_path / "rig.yaml"
    rig.write_text(
        "rig: {m: 1, d: 0, k_f: 0, k_c: 1.0e4}\nrelative_std: {q: 0.1, m: 3}\ntried: {v_e: [2, 1], f_p: 3}\nx: 1\n"
    )
    found = faults(call, "check", "--model", rig, *PALM)
    for part in ("relative_std.q", "relative_std.m", "tried.v_e", "tried.f_p", "x: is not known"):
        assert part in found
    rig.write_text("rig: {m: 1900, d: 60, k_f: 800, k_c: 60}\ntried: {v_e: [20, 1500], f_p: [20, 120]}\n")
    found = faults(call, "check", "--model", rig, *PALM[:4], "--v-e", "200", "--f-p", "0.06")
    for part in ("rig.m: must be at most", "if it is in N/mm, multiply by 1000", "tried.v_e: must be at most",
                 "--v-e must be at most 5 m/s", "--f-p must be at least 1 N"):  # fmt: skip
        assert part in found
    assert not list(tmp_path.glob("*.csv.*"))


def test_a_model_that_is_not_one_is_refused(call, tmp_path):
    model = tmp_path / "model.json"
    model.write_text('{"schema": "acf-gap-diagnosis/1"}')
    assert "its schema is not acf-gap-model/1" in faults(
        call, "speed", "--model", model, "--f-p", "1", "--limit", "9"
    )
    assert "--limit must be a number, finite and positive" in faults(
        call, "speed", "--model", RIG, "--f-p", "1", "--limit", "-9"
    )


@pytest.mark.long
def test_a_limit_holds_until_the_robot_has_stopped(call, tmp_path):
    """Carried along for 55 mm, this flange presses with 60 N, 44 N of its spring and d v."""
    rig = tmp_path / "rig.yaml"
    rig.write_text("rig: {m: 1.9, d: 60.0, k_f: 800.0, k_c: 6.0e+4}\n")
    asked = ("--model", rig, "--f-p", "60", "--limit", "120", "--travel", "0.055", "--draws", "400", "--json")
    (found,) = json.loads(call("speed", *asked).output)["speeds"]
    assert found["v_e"] == pytest.approx((120 - 60 - 800 * 0.055) / 60, rel=1e-4)
    assert found["robot_stops_within_m"] == pytest.approx(0.055)
    assert found["robot_stops_within_s"] == pytest.approx(0.055 / found["v_e"])


@pytest.mark.parametrize("command", ["speed", pytest.param("design", marks=pytest.mark.long)])
@pytest.mark.parametrize(
    "ending",
    [
        pytest.param({"stop_after": 0.001}, marks=pytest.mark.long),
        {"travel": 0.0003},
        pytest.param({"reaction": 0, "deceleration": 200}, marks=pytest.mark.long),
    ],
    ids=["time", "travel", "braking"],
)
def test_an_early_stop_does_not_stop_the_flange(call, tmp_path, ending, command):
    """A robot that stops after 1 ms: what is left is a mass on two springs, whatever the ending is called."""
    rig = tmp_path / "rig.yaml"
    rig.write_text("rig: {m: 1.9, d: 0.0, k_f: 800.0, k_c: 6.0e+4}\n")
    rest = 60 / 60800
    highest = np.sqrt(((80 / 6e4 + rest) ** 2 - rest**2) * 60800 / 1.9)
    if command == "speed":
        asked = ("speed", "--model", rig, "--f-p", "60", "--limit", "140", "--draws", "400", "--json")
        options = [part for name, value in ending.items() for part in (f"--{name.replace('_', '-')}", value)]
        (found,) = json.loads(call(*asked, *options).output)["speeds"]
    else:
        config = tmp_path / "design.yaml"
        config.write_text(f"model: {rig}\ngoal: fastest\nlimit: 140\nf_p: 60\nv_e: {{low: 0.02, high: 1}}\n"
                          f"ending: {json.dumps(ending)}\n")  # fmt: skip
        designed = json.loads(call("design", "--config", config, "--json").output)
        assert designed["feasible"]
        found = designed["optimum"]
    assert 0.97 * highest < found["v_e"] < highest


def test_no_speed_is_stated_at_which_the_robot_travels_farther_than_is_left(call):
    """Of 100 mm/s for 50 ms and 5 mm, the deviation of the speed is to spare."""
    ending = ("--stop-after", "0.05", "--travel", "0.005")
    asked = ("--f-p", "60", "--limit", "120", "--draws", "400", "--json")
    (found,) = json.loads(call("speed", "--model", RIG, *asked, *ending).output)["speeds"]
    assert 0.09 < found["v_e"] < 0.1 and found["robot_stops_within_m"] < 0.005 and not found["limit_reached"]
    one = ("--body-area", "palm", "--contact", "quasi_static", "--f-p", "60", *ending)
    near = json.loads(call("check", "--model", RIG, *one, "--v-e", "0.0999", "--json").output)
    assert near["verdict"] == "not decidable" and near["must_stop_within_m"] < 0.005


def test_a_design_knows_that_a_diagnosis_brakes_the_robot_itself(call, tmp_path):
    model, config = tmp_path / "model.json", tmp_path / "design.yaml"
    model.write_text(write_model(gap_model(("robot_deceleration",), (5.0, 0.0, 1e-3))))
    config.write_text(f"model: {model}\ngoal: fastest\nlimit: 120\nf_p: 60\nv_e: {{low: 0.05, high: 0.3}}\n"
                      "ending: {reaction: 0.1, deceleration: 2}\n")  # fmt: skip
    assert "ending: the corrected model brakes the robot itself" in faults(call, "design", "--config", config)


def test_an_ending_that_cannot_be_is_refused_by_every_command(call, tmp_path):
    config = tmp_path / "design.yaml"
    config.write_text(f"model: {RIG}\ngoal: fastest\nlimit: 120\nf_p: 60\nv_e: {{low: 0.02, high: 1}}\n"
                      "ending: {travel: 20, deceleration: 2}\n")  # fmt: skip
    one = ("--body-area", "palm", "--contact", "transient", "--v-e", "0.1", "--f-p", "60")
    for command in (
        ("check", "--model", RIG, *one, "--travel", "20", "--deceleration", "2"),
        ("speed", "--model", RIG, "--f-p", "60", "--limit", "100", "--travel", "20", "--deceleration", "2"),
        ("design", "--config", config),
    ):
        found = faults(call, *command)
        assert "mm, divide by 1000" in found and "belong together" in found
    table = tmp_path / "situations.csv"
    table.write_text(
        "situation,body_area,contact,contact_velocity_m_per_s,pretension_n,stop_after_s,travel\n"
        "a,palm,transient,0.1,20,-1,\n"
    )
    found = faults(call, "check", "--model", RIG, "--situations", table, "--json")
    assert "row 2: stop_after_s must be positive" in found and "did you mean 'travel_m'" in found


def test_a_table_names_the_first_row_of_each_verdict(call, tmp_path):
    table, out = tmp_path / "situations.csv", tmp_path / "verdicts.csv"
    table.write_text(
        "situation,body_area,contact,contact_velocity_m_per_s,pretension_n\n"
        '"first\nof two lines",palm,transient,0.1,60\n\nopen,palm,quasi_static,0.3,60\n'
        '"on\ntwo",Face,transient,0.1,60\n'
    )
    result = call("check", "--model", RIG, "--situations", table, "--out", out)
    assert "first that is not allowed: row 6, 'on\ntwo', " in result.output
    assert "first that is not decidable: row 5, 'open', Palm" in result.output
    with out.open(newline="") as file:
        verdicts = {row["situation"]: row["verdict"] for row in csv.DictReader(file)}
    assert verdicts == {"first\nof two lines": "allowed", "open": "not decidable", "on\ntwo": "not allowed"}


def test_many_missing_files_are_one_line(call, tmp_path):
    names = [f"rig{i:02}" for i in range(21)]
    for name in names:
        (tmp_path / "sets" / name / "traces").mkdir(parents=True)
        (tmp_path / "sets" / name / "trials.csv").write_text("")
    told = faults(call, "fleet", tmp_path / "sets", "--out", tmp_path / "out").splitlines()
    (missing,) = [line for line in told if "no such file" in line]
    first = ", ".join(f"{tmp_path}/sets/{name}/dataset.yaml" for name in names[:3])
    assert missing == f"{first} and 18 more: no such file; check the path"
    assert sum("is empty" in line for line in told) == 1


@pytest.mark.parametrize("count, lines", [(3, 3), (4, 1)])
def test_few_inputs_with_one_fault_have_a_line_each(count, lines):
    names = [f"sets/{i}" for i in range(count)]
    for file in ("/dataset.yaml", ""):
        told = merged((name, [f"{name}{file}: no such file; check the path"]) for name in names)
        assert len(told) == lines and all("no such file; check the path" in line for line in told)
    apart = merged((name, [f"{name}: row {i} is empty"]) for i, name in enumerate(names))
    assert apart == [f"{name}: row {i} is empty" for i, name in enumerate(names)]
    assert merged((name, ["the processes cannot be had"]) for name in names) == [
        "the processes cannot be had"
    ]
    assert len(InputError([f"{i}.csv: no such file; check the path" for i in range(9)]).faults) == 9
