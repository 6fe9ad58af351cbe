"""What the pages write, the commands read, and the other way round; two tabs do not corrupt one another."""

import json
import re
from pathlib import Path

import pytest
import yaml
from click.testing import CliRunner
from served import RIG, Served, wait

from acf_jax.app import jobs, signals
from acf_jax.app.pages import planning
from acf_jax.cli.main import commands as command_line
from acf_jax.errors import InputError
from acf_jax.recording.rig import read_rig_file

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"


def version(app: Served, page: str) -> str:
    """Which content of its file a page shows."""
    return app.get(page).text.split('name="version" value="')[1].split('"')[0]


@pytest.fixture(scope="module")
def cut(app: Served, wrong_sign: Path) -> str:
    """A session whose recording had a wrong sign, which one click has put right."""
    answer = app.upload(wrong_sign)
    assert answer.status == 200
    url: str = answer.json["next"].removesuffix("/open")
    page = app.get(f"{url}/open").text
    assert "checked" in page.split('id="tare"')[1].split(">")[0]
    assert "column" in page and 'value="[&quot;force_n&quot;, null]" selected' in page
    fields = {"force": '["force_n", null]', "speed": '["velocity_m_per_s", null]', "speed-kind": "velocity",
              "pretension": '["pretension_n", null]', "tare": "on"}  # fmt: skip
    assert app.post(f"{url}/signals", fields | {"version": version(app, f"{url}/open")}).status == 303
    assert wait(app, url).state == "failed"
    page = app.get(f"{url}/cut").text
    assert "is negative in contact" in page and "Turn the sign of the force, and cut again" in page
    fields = {"version": version(app, f"{url}/cut"), "role": "force", "factor": "-1.0"}
    assert app.post(f"{url}/rescale", fields).status == 303
    assert wait(app, url).state == "done"
    return url


@pytest.mark.long
def test_a_wrong_sign_is_put_right_by_one_click(app: Served, cut: str) -> None:
    mapping = yaml.safe_load((app.home / "pressed/mapping.yaml").read_text())
    assert mapping["force"] == {"name": "force_n", "scale": -1.0}
    rows = (app.home / "pressed/data/trials.csv").read_text().splitlines()
    assert len(rows) == 9 and "import.html" in app.get(f"{cut}/cut").text
    assert "checked" in app.get(f"{cut}/open").text.split('name="force-turned"')[1].split(">")[0]


@pytest.mark.long
def test_the_command_repeats_what_the_page_did(
    app: Served, cut: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = app.home / "pressed"
    script = app.get(f"{cut}/script.sh").text
    command = script.splitlines()[-1].split()
    assert command[:4] == ["python", "-m", "acf_jax", "import"]
    monkeypatch.chdir(folder)
    again = [part if part != "data" else "again" for part in command[3:]]
    assert CliRunner().invoke(command_line, again).exit_code == 0
    for name in ("trials.csv", "dataset.yaml"):
        assert (folder / "again" / name).read_text() == (folder / "data" / name).read_text()
    python = app.get(f"{cut}/script.py").text
    compile(python, "script", "exec")
    assert "mapping='mapping.yaml'" in python


@pytest.mark.long
def test_cuts_are_saved_dropped_and_forgotten(app: Served, cut: str) -> None:
    page = app.get(f"{cut}/cut").text
    seen = page.split('data-version="')[1].split('"')[0]
    assert seen == "none"
    text = (app.home / "pressed/data/import.html").read_text()
    cuts = json.loads(text.split('id="cuts-data">')[1].split("</script>")[0])["cuts"]
    sent = [{key: c[key] for key in ("trial", "contact_s", "keep")} for c in cuts]
    sent[2]["keep"] = False
    sent[3]["contact_s"] += 0.001

    def save(cuts: object, version: str) -> int:
        body = json.dumps({"cuts": cuts, "version": version})
        return app.post(
            f"{cut}/cuts", body, Content_Type="application/json", Accept="application/json"
        ).status

    for wrong in (
        None,
        3,
        [],
        [{"trial": "../x", "contact_s": 1, "keep": True}],
        [{"trial": "a", "contact_s": -1, "keep": True}],
    ):
        assert wrong == [] or save(wrong, seen) == 400
    assert save(sent, seen) == 200
    assert wait(app, cut).state == "done"
    rows = (app.home / "pressed/data/trials.csv").read_text().splitlines()
    assert len(rows) == 8 and not any(row.startswith("t002") for row in rows)
    moved = next(row for row in rows if row.startswith("t003")).split(",")[-1]
    assert float(moved) == pytest.approx(sent[3]["contact_s"], abs=1e-8)
    # another tab still shows the page from before
    assert save(sent, seen) == 409
    page = app.get(f"{cut}/cut").text
    assert "Forget what was decided" in page
    assert app.post(f"{cut}/forget-cuts", {"version": version(app, f"{cut}/cut")}).status == 303
    assert wait(app, cut).state == "done" and not (app.home / "pressed/cuts.yaml").exists()
    assert len((app.home / "pressed/data/trials.csv").read_text().splitlines()) == 9


@pytest.mark.long
def test_the_rig_is_one_file_in_si_units(app: Served, cut: str) -> None:
    seen = version(app, f"{cut}/rig")
    grams = RIG | {"m-value": "2100", "m-std": "40", "m-unit": "g", "noise": "1.2", "tool": "1.3"}
    assert app.post(f"{cut}/rig", grams | {"version": seen}).status == 303
    assert wait(app, cut).state == "done"
    known = read_rig_file(app.home / "pressed/rig.yaml")
    assert (known.prior.m.value, known.prior.m.std) == (2.1, 0.04)
    assert (known.prior.k_c.value, known.prior.k_f.std) == (340e3, 500.0)
    assert known.measurement == {"force_noise_std_n": 1.2, "tool_mass_kg": 1.3}
    assert read_rig_file(app.home / "pressed/data/dataset.yaml").prior == known.prior
    page = app.get(f"{cut}/rig").text
    assert 'value="340"' in page and 'value="2.1"' in page
    # the other tab, which showed the page before, writes nothing
    assert app.post(f"{cut}/rig", RIG | {"version": seen}).status == 409
    assert read_rig_file(app.home / "pressed/rig.yaml").prior == known.prior


@pytest.mark.long
def test_a_rig_that_cannot_be_is_told_by_the_form_s_words(app: Served, cut: str) -> None:
    before = (app.home / "pressed/rig.yaml").read_bytes()
    for changed, told in (
        ({"m-value": "2100"}, "Moving mass"),
        ({"d-std": "0"}, "Damping, standard deviation"),
        ({"k_c-value": "x"}, "Stiffness of the contact, value"),
        ({"k_f-value": ""}, "Stiffness of the actuator, value"),
        ({"m-unit": "t"}, "no unit"),
        ({"noise": "-1"}, "Noise of the force sensor"),
        ({"tool": "2.2"}, "Tool before the sensor: is 2.2 kg, more than all that moves"),
        ({"m-value": "nan"}, "Moving mass"),
    ):
        answer = app.post(f"{cut}/rig", RIG | changed | {"version": version(app, f"{cut}/rig")})
        assert answer.status == 400 and told in answer.text, changed
        if "d-value" not in changed and "m-unit" not in changed:
            assert 'value="60"' in answer.text  # what was entered is not lost
    assert (app.home / "pressed/rig.yaml").read_bytes() == before


@pytest.mark.long
def test_where_a_job_runs_no_file_is_changed(app: Served, cut: str) -> None:
    """What a page says beside `a job runs already` is not written either."""
    import fcntl

    folder = app.home / "pressed"
    kept = {path: path.read_bytes() for path in sorted(folder.glob("*.yaml"))}
    versions = {name: version(app, f"{cut}/{page}") for name, page in (("mapping", "open"), ("rig", "rig"))}
    fields = {"force": '["force_n", null]', "speed-kind": "velocity", "version": versions["mapping"]}
    cuts = json.dumps({"cuts": [{"trial": "t000", "contact_s": 1.0, "keep": False}], "version": "none"})
    (folder / ".app/job.json").write_text('{"kind": "import"}')
    (folder / ".app/import/code.txt").unlink()
    with (folder / ".app/lock").open("a") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        answers = [
            app.post(f"{cut}/signals", fields),
            app.post(f"{cut}/rescale", {"version": versions["mapping"], "role": "force", "factor": "2"}),
            app.post(f"{cut}/rig", RIG | {"version": versions["rig"], "m-value": "3"}),
            app.ask("POST", f"{cut}/cuts", cuts, Content_Type="application/json"),
            app.post(f"{cut}/forget-cuts", {"version": "none"}),
            app.post(f"{cut}/plan", {"of": "sliders"} | {n: str(s[4]) for n, s in planning.SLIDERS.items()}),
        ]
    (folder / ".app/import/code.txt").write_text("0\n")
    for answer in answers:
        assert answer.status == 400 and "a job runs in this session already" in answer.text
    assert {path: path.read_bytes() for path in sorted(folder.glob("*.yaml"))} == kept
    assert not (folder / "plan").exists()


def test_a_folder_of_run_or_of_import_is_a_session(app: Served) -> None:
    out = app.home / "from commands"
    command = ["import", str(EXAMPLES / "session.mcap"), "--rig", str(EXAMPLES / "session_rig.yaml"), "--out"]
    assert CliRunner().invoke(command_line, [*command, str(out / "data")]).exit_code == 0
    assert "from commands" in app.get("/").text
    page = app.get("/s/0/from%20commands/cut").text
    assert "import.html" in page and ">Describe the rig<" not in page.split("</nav>")[1]
    rig = app.get("/s/0/from%20commands/rig").text
    assert 'value="1.74762"' in rig
    # its rig can be written where there is no recording to cut again
    answer = app.post("/s/0/from%20commands/rig", RIG | {"version": "none"})
    assert answer.status == 303 and answer.headers["location"].endswith("/diagnose")
    assert read_rig_file(out / "data/dataset.yaml").prior.m.value == 2.1


def test_a_data_set_is_copied_and_its_faults_are_told(app: Served, tmp_path: Path) -> None:
    import shutil

    shutil.copytree(EXAMPLES / "rig", app.home / "a data set")
    (app.home / "a data set/secret.txt").write_text("not listed")
    answer = app.post("/open", {"place": "0", "path": "a data set"})
    assert answer.status == 303 and answer.headers["location"] == "/s/0/a%20data%20set%202/diagnose"
    copied = app.home / "a data set 2/data"
    described, url = copied / "dataset.yaml", "/s/0/a%20data%20set%202/rig"
    for given, known in ({"noise": "1.2", "tool": "1.3"}, 2), ({}, 0):
        assert app.post(url, RIG | given | {"version": version(app, url)}).status == 303
        measurement = read_rig_file(described).measurement
        assert len({"force_noise_std_n", "tool_mass_kg"} & set(measurement)) == known
    assert (copied / "trials.csv").read_bytes() == (EXAMPLES / "rig/trials.csv").read_bytes()
    assert len(list((copied / "traces").iterdir())) == 16 and not (copied / "secret.txt").exists()
    (app.home / "a data set/trials.csv").write_text("trial\n")
    before = len(list(app.home.iterdir()))
    assert app.post("/open", {"place": "0", "path": "a data set"}).status == 400
    assert len(list(app.home.iterdir())) == before


def test_plan_asks_before_any_data(app: Served) -> None:
    url = app.post("/new", {"name": "before"}).headers["location"].removesuffix("/rig")
    sliders = {"slowest": "0.05", "fastest": "0.3", "speeds": "2", "least": "60", "most": "60", "pretensions": "1",
               "repeats": "2", "rate": "8000", "noise": "1"}  # fmt: skip
    assert "describe it first" in app.post(f"{url}/plan", sliders).text
    assert app.post(f"{url}/rig", RIG | {"version": "none"}).headers["location"].endswith("/plan")
    for wrong in ({"slowest": "0.4"}, {"repeats": "1"}, {"rate": "x"}, {"noise": "1e9"}):
        answer = app.post(f"{url}/plan", sliders | wrong)
        assert answer.status == 400 and not (app.home / "before/plan").exists(), wrong
    assert app.post(f"{url}/plan", sliders).status == 303
    trials = (app.home / "before/plan/trials.csv").read_text().splitlines()
    assert trials[1:] == ["t000,0.05,60", "t001,0.05,60", "t002,0.3,60", "t003,0.3,60"]
    jobs.cancel(app.home / "before")
    wait(app, url)
    assert 'id="speeds" name="speeds" value="2"' in app.get(f"{url}/plan").text


def test_a_session_whose_name_is_quoted_keeps_it_in_a_query(app: Served) -> None:
    folder = app.home / "a+b"
    folder.mkdir()
    (folder / "some.csv").write_text("time_s,force_n\n0,0\n1,2\n")
    (folder / "session.yaml").write_text("schema: acf-session/1\nrecording: some.csv\n")
    page = app.get("/s/0/a+b/open").text
    (link,) = re.findall(r'href="(/browse/0/\?session=[^"]*)"', page)
    assert 'name="session" value="0/a+b"' in app.get(link).text


def test_steps_that_come_too_early_say_what_is_first(app: Served) -> None:
    url = app.post("/new", {"name": "early"}).headers["location"].removesuffix("/rig")
    for step, told in (("open", "no recording yet"), ("cut", "Nothing is cut yet"), ("diagnose", "No data set yet"),
                       ("use", "first: its corrected model"), ("plan", "Describe the rig")):  # fmt: skip
        answer = app.get(f"{url}/{step}")
        assert answer.status == 200 and told in answer.text
    assert app.get(f"{url}/report.pdf").status == 404
    assert app.post(f"{url}/signals", {"version": "none"}).status == 400
    assert app.get(f"{url}/curve", Accept="application/json").status == 400


def test_what_the_form_does_not_show_stays_in_the_mapping() -> None:
    before = {
        "force": {"name": "a", "scale": -2.0},
        "velocity": {"name": "b", "clock_offset_s": 1.5, "scale": 0.001},
        "time_scale": 0.001,
        "contacts": {"separation_s": 0.2, "tare": True},
    }
    fields = {
        "force": '["a", null]', "force-unit": "2.0", "force-turned": "on", "speed": '["b", null]',
        "speed-kind": "velocity", "speed-unit": "mm/s", "pretension": "number", "pretension-number": "60",
    }  # fmt: skip
    after = signals.mapped(before, fields)
    assert after == before | {"pretension": 60.0, "contacts": {"separation_s": 0.2, "tare": False}}
    # zero is taken off by default: a tick is no word more
    assert signals.mapped(before, fields | {"tare": "on"})["contacts"] == {"separation_s": 0.2}
    assert signals.mapped({}, {"tare": "on", "speed-kind": "velocity"}) == {}
    for role, value, unit in (("force", '["a", null]', "2.0"), ("speed", '["b", null]', "mm/s")):
        shown = signals.chosen(before, role)
        assert (shown.value, shown.unit) == (value, unit)
    # another signal has another clock
    assert "clock_offset_s" not in signals.mapped(before, fields | {"speed": '["c", null]'})["velocity"]
    position = signals.mapped(
        before, fields | {"speed": '["p", "x"]', "speed-kind": "position", "speed-unit": "mm"}
    )
    assert "velocity" not in position and position["position"] == {"name": "p", "field": "x", "scale": 0.001}


@pytest.mark.parametrize(
    "wrong, told",
    [
        ({"force": "force_n"}, "no signal of the list"),
        ({"force": "3"}, "no signal of the list"),
        ({"force": "[3, null]"}, "no signal of the list"),
        ({"pretension": "number"}, "none is given"),
        ({"pretension-number": "60 N"}, "no number"),
        ({"force-turned": "on"}, "name the signal"),
        ({"speed-kind": "mass"}, "neither velocity nor position"),
    ],
)
def test_a_form_of_signals_that_cannot_be(wrong: dict[str, str], told: str) -> None:
    with pytest.raises(InputError, match=told):
        signals.mapped({}, {"speed-kind": "velocity"} | wrong)


def test_remedies_are_offered_only_where_a_message_leaves_no_doubt() -> None:
    content = {"force": {"name": "Fz"}, "velocity": {"name": "v"}, "pretension": {"name": "p"}}
    one = "a.csv column 'Fz': is negative in contact; put -1* before its name"
    two = "a.csv column 'Fz': if in kN, put 1000* before its name, or if in kgf, put 9.80665* before its name"
    both = "a.csv column 'Fz': and 'v': put 0.001* before its name"
    longer = "a.csv column 'Fzz': put -1* before its name"
    found = signals.remedies([one, two, both, longer, "nothing"], content, {})
    assert [(r.role, r.factor) for r in found] == [("force", -1.0)]
    offered = {"candidates": {"force": [{"name": "Fz", "field": None}]}}
    assert signals.rescaled({}, offered, "force", -1.0) == {"force": {"name": "Fz", "scale": -1.0}}
    with pytest.raises(InputError, match="no signal is named"):
        signals.rescaled({}, {}, "force", -1.0)
