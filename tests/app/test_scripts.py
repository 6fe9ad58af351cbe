"""The scripts that a session gives away, run: they repeat every step, with the same numbers."""

import json
import os
import re
import shutil
import subprocess
import sys
from html import unescape
from pathlib import Path

import numpy as np
import pytest
from served import RIG, Served, wait

from acf_jax.app.pages import planning
from acf_jax.effects import library

MODEL = Path(__file__).parents[2] / "examples/rig_model.json"
QUESTIONS = {
    "speed": {"f_p": "60", "limit": "120"},
    "design": {"limit": "130", "v-low": "0.05", "v-high": "0.3", "f-low": "50", "f-high": "90", "goal": "fastest"},
    "check": {"v": "0.12", "f_p": "60", "area": "palm", "contact": "quasi_static", "stop": "0.05"},
}  # fmt: skip


def asked(app: Served, url: str) -> dict[str, str]:
    """What the page answers."""
    answers = {}
    for question, fields in QUESTIONS.items():
        answer = app.post(f"{url}/ask/{question}", fields, Accept="application/json")
        assert answer.status == 200, answer.text
        answers[question] = unescape(re.sub("<[^>]+>", " ", answer.json["html"]))
    return answers


def run(folder: Path, text: str, kind: str) -> str:
    """What a script prints."""
    (folder / f"session.{kind}").write_text(text)
    program = ["sh"] if kind == "sh" else [sys.executable]
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    done = subprocess.run(
        [*program, f"session.{kind}"],
        cwd=folder,
        env=os.environ | {"PATH": path},
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def check_numbers(answers: dict[str, str], printed: str) -> None:
    """Each number that the page has shown is printed, to three digits: the page may round it to fewer."""

    def numbers(text: str) -> np.ndarray:
        return np.unique([float(number) for number in re.findall(r"(?<![\w/-])\d+\.?\d*", text)])

    there = numbers(printed)
    for question in QUESTIONS:
        shown = numbers(answers[question])
        off = np.abs(there - shown[:, None]).min(axis=1)
        assert len(shown) >= 5 and (off <= 2e-3 * shown).all(), (question, shown[off > 2e-3 * shown], printed)


@pytest.fixture(scope="module")
def whole(app: Served, wrong_sign: Path) -> tuple[Path, dict[str, str]]:
    """A session after every step, one contact dropped and one moved by hand, and the answers of its page."""
    url = app.upload(wrong_sign, name="every step.csv").json["next"].removesuffix("/open").replace(" ", "%20")
    folder = app.home / "every step"
    fields = {"force": '["force_n", null]', "force-turned": "on", "speed": '["velocity_m_per_s", null]',
              "speed-kind": "velocity", "pretension": '["pretension_n", null]', "version": "none",
              "tare": "on"}  # fmt: skip
    assert app.post(f"{url}/signals", fields).status == 303
    assert wait(app, url).state == "done"
    assert app.post(f"{url}/rig", RIG | {"noise": "0.8", "version": "none"}).status == 303
    assert wait(app, url).state == "done"
    text = (folder / "data/import.html").read_text()
    cuts = json.loads(text.split('id="cuts-data">')[1].split("</script>")[0])["cuts"]
    sent = [{key: c[key] for key in ("trial", "contact_s", "keep")} for c in cuts]
    sent[1]["keep"] = False
    sent[3]["contact_s"] += 0.0005
    body = json.dumps({"cuts": sent, "version": "none"})
    assert app.ask("POST", f"{url}/cuts", body, Content_Type="application/json").status == 200
    assert wait(app, url).state == "done"
    sliders = {name: str(s[4]) for name, s in planning.SLIDERS.items()}
    assert app.post(f"{url}/plan", sliders | {"speeds": "2", "pretensions": "1"}).status == 303
    assert wait(app, url).state == "done"
    assert app.post(f"{url}/diagnose", {"cause": ["end_stop", "gravity"]}).status == 303
    assert wait(app, url).state == "done"
    answers = asked(app, url)
    assert app.post(f"{url}/ask/speed", {"f_p": "a", "limit": "1"}, Accept="application/json").status == 400
    return folder, answers | {"sh": app.get(f"{url}/script.sh").text, "py": app.get(f"{url}/script.py").text}


def plain(content: str) -> dict[str, object]:
    """diagnosis.json without what only the path of its data set tells."""
    return {key: value for key, value in json.loads(content).items() if key != "data_set"}


@pytest.mark.long
@pytest.mark.parametrize("kind", ["sh", "py"])
def test_a_script_repeats_every_step(whole: tuple[Path, dict[str, str]], tmp_path: Path, kind: str) -> None:
    folder, answers = whole
    again = tmp_path / "again"
    given = ("session.yaml", "mapping.yaml", "cuts.yaml", "rig.yaml", "recording", "plan", "design.yaml")
    for name in given:  # what was decided; what was computed is not there
        copy = shutil.copytree if (folder / name).is_dir() else shutil.copy
        copy(folder / name, again / name) if again.mkdir(exist_ok=True) is None else None
    printed = run(again, answers[kind], kind)
    if kind == "sh":
        for name in ("trials.csv", "dataset.yaml"):
            assert (again / "data" / name).read_text() == (folder / "data" / name).read_text()
        assert plain((again / "diagnosis/diagnosis.json").read_text()) == plain(
            (folder / "diagnosis/diagnosis.json").read_text()
        )
    first, second = (json.loads((f / "diagnosis/model.json").read_text()) for f in (folder, again))
    assert first["corrected"] == second["corrected"] and first["data_sha256"] == second["data_sha256"]
    check_numbers(answers, printed)
    assert "end_stop" in printed and '"smallest_detectable"' in printed  # of the plan


@pytest.mark.long
def test_a_script_leaves_nothing_out(whole: tuple[Path, dict[str, str]]) -> None:
    _, answers = whole
    commands = [
        line.split()[3] for line in answers["sh"].splitlines() if line.startswith("python -m acf_jax")
    ]
    assert commands == ["import", "plan", "diagnose", "speed", "design", "check"]
    assert answers["sh"].count("--without") == len(library()) - 2
    assert "review='cuts.yaml'" in answers["py"]


@pytest.mark.long
def test_a_script_asks_the_same_questions(app: Served) -> None:
    folder = app.home / "asked"
    (folder / "diagnosis").mkdir(parents=True)
    shutil.copy(MODEL, folder / "diagnosis/model.json")
    (folder / "diagnosis/diagnosis.json").write_text("{}")
    answers = asked(app, "/s/0/asked")
    shell, python = (app.get(f"/s/0/asked/script.{kind}").text for kind in ("sh", "py"))
    assert "diagnose" not in shell + python  # the data set is not there
    check_numbers(answers, run(folder, shell, "sh"))
    check_numbers(answers, run(folder, python, "py"))


def test_a_script_takes_no_word_of_a_foreign_folder(app: Served) -> None:
    """Names, options and questions that came with a session stay what they are, or are left out."""
    folder = app.home / "foreign words"
    (folder / "diagnosis").mkdir(parents=True)
    shutil.copy(MODEL, folder / "diagnosis/model.json")
    (folder / "diagnosis/diagnosis.json").write_text("{}")
    (folder / "data").mkdir()
    (folder / "data/trials.csv").write_text("")
    command = "acf-jax diagnose x --without end_stop --without '; rm -rf ~' --low-pass $(id)"
    (folder / "diagnosis/provenance.json").write_text(json.dumps({"command": command, "made_of": 3}))
    (folder / ".app").mkdir()
    asked = {
        "speed": {"f_p": "1; id", "limit": "2"},
        "check": {"area": "x'; id; '", "v": "1", "f_p": "2"},
        "design": 3,
    }
    (folder / ".app/asked.json").write_text(json.dumps(asked))
    shell, python = (app.get(f"/s/0/foreign%20words/script.{kind}").text for kind in ("sh", "py"))
    assert "rm -rf" not in shell and "$(id)" not in shell and "speed" not in shell and "design" not in shell
    assert "--without end_stop" in shell and "'x'\"'\"'; id; '\"'\"''" in shell
    compile(python, "script", "exec")
    assert "body_area=\"x'; id; '\"" in python
