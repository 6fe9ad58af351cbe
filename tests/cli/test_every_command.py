"""What holds for every command that the command line finds, and for `python -m train.fit`."""

import csv
import io
import json
import os
import shutil
from pathlib import Path

import click
import pytest

from acf_jax.cli.main import commands, main
from acf_jax.gap_model import write_model
from acf_jax.start import check_devices
from tests.corrected import gap_model
from tests.few import few_explanations

ROOT = Path(__file__).resolve().parents[2]
RIG = ROOT / "configs/table1_rig.yaml"


def leaves(command: click.Command, *path: str) -> dict[tuple[str, ...], click.Command]:
    """Every command and subcommand by the words that call it."""
    found = {path: command} if path else {}
    if isinstance(command, click.Group):
        context = click.Context(command)
        for name in command.list_commands(context):
            found |= leaves(command.get_command(context, name), *path, name)
    return found


COMMANDS = leaves(commands)
EVERY = pytest.mark.parametrize("path", COMMANDS, ids=" ".join)
SERVES = ("app",)  # answers in a browser, until it is stopped: tests/app
ANSWERING = pytest.mark.parametrize("path", [path for path in COMMANDS if path != SERVES], ids=" ".join)

# Arguments with which each command answers quickly; a new command needs a line. FOLDER is the test's own.
ANSWERS = {
    "peak": ["--rig", RIG, "--f-p", 100, "--v-e", 0.2],
    "identify": [ROOT / "configs/table1.csv"],
    "speed": ["--model", RIG, "--f-p", 100, "--limit", 250],
    "design": ["--config", ROOT / "configs/design.yaml"],
    "check": ["--model", RIG, "--situations", ROOT / "configs/situations.csv"],
    "plan": [
        ROOT / "examples/session_rig.yaml",  # a dataset.yaml will do, too
        "--conditions",
        ROOT / "examples/rig/held_out_conditions.csv",
    ],
    "import": [
        ROOT / "examples/session.mcap",
        "--out",
        "FOLDER/out",
        "--rig",
        ROOT / "examples/session_rig.yaml",
    ],
    "run": [
        ROOT / "examples/session.mcap",
        "--out",
        "FOLDER/out",
        "--rig",
        ROOT / "examples/session_rig.yaml",
        "--limit",
        140,
    ],
    "diagnose": [ROOT / "examples/rig", "--out", "FOLDER/out"],
    "predict": [
        "FOLDER/model",
        "--conditions",
        ROOT / "configs/conditions_example.csv",
        "--out",
        "FOLDER/out",
    ],
    "fleet": ["FOLDER/sets", "--out", "FOLDER/out"],
    "train": ["FOLDER/model", "--out", "FOLDER/out", "--samples", 1024, "--steps", 50],
    "export": ["--c", "FOLDER/acf_peak.h"],
    "blind seal": ["FOLDER/sets"],
    "blind score": ["FOLDER/sets", "--out", "FOLDER/out", "--workers", 1],
    "blind": ["--out", "FOLDER/out", "--cases", 4, "--world", "scipy"],
}


@pytest.fixture
def end(monkeypatch, capsys):
    """Exit code, standard output and standard error of a command line."""
    monkeypatch.setattr("acf_jax.start.start_jax", lambda: None)  # tests set JAX themselves

    def ending(*arguments: object) -> tuple[int, str, str]:
        with pytest.raises(SystemExit) as caught:
            main([str(a) for a in arguments])
        return caught.value.code, *capsys.readouterr()

    return ending


def is_one_message(text: str) -> bool:
    lines = text.splitlines()
    told = lines and all(
        line.startswith("error: ") or line.endswith("tells how it is used") for line in lines
    )
    return bool(told) and "Traceback" not in text


@EVERY
def test_help_tells_arguments_and_examples(path, end):
    code, text, error = end(*path, "--help")
    assert code == 0 and not error
    assert text.startswith("Usage: python -m acf_jax ") and f"python -m acf_jax {path[0]} " in text
    assert ("--json" in text) == (path != SERVES)


@EVERY
def test_an_unknown_option_is_a_fault(path, end):
    code, text, error = end(*path, "--jsom")
    assert code == 2 and not text
    assert is_one_message(error) and "--jsom" in error and "--help tells" in error


@EVERY
def test_files_that_do_not_exist_are_one_message(path, end, tmp_path):
    given = []
    for parameter in COMMANDS[path].params:
        if isinstance(parameter, click.Argument):
            given.append(tmp_path / "none")
        elif isinstance(parameter.type, click.Path) and "--out" not in parameter.opts:
            given += [parameter.opts[0], tmp_path / "none"]
        elif parameter.required:
            given += [parameter.opts[0], tmp_path / "out" if "--out" in parameter.opts else 1]
    code, text, error = end(*path, *given)
    assert code == 2 and not text
    assert is_one_message(error)
    assert not list(tmp_path.iterdir())


@ANSWERING
def test_ctrl_c_leaves_nothing_half_written(path, end, monkeypatch, tmp_path):
    def stop() -> None:
        raise KeyboardInterrupt

    arguments = prepared(path, tmp_path)
    before = files(tmp_path)
    monkeypatch.setattr("acf_jax.start.start_jax", stop)
    monkeypatch.setattr("os.replace", lambda *names: stop())  # the last moment of a command without JAX
    for module in ("validation.blind.campaign", "acf_jax.fleet.run"):
        monkeypatch.setattr(f"{module}.run_all", lambda *rest: stop())
    code, text, error = end(*path, *arguments)
    assert code == 130 and not text
    assert error.startswith("\nstopped; ") and len(error.splitlines()) == 2
    assert ("goes on" in error) == (path in (("blind",), ("blind", "score"), ("fleet",)))
    assert files(tmp_path) == before


@ANSWERING
def test_a_device_that_jax_does_not_have_is_one_message(path, end, monkeypatch, tmp_path):
    def none() -> None:
        raise AssertionError  # as of JAX_PLATFORMS=cuda, where its plugin is not installed

    def started(work, pieces, where):
        check_devices()  # as the processes' start does: tests/fleet/test_fleet_run.py

    arguments = prepared(path, tmp_path)
    monkeypatch.setenv("JAX_PLATFORMS", "cuda")
    monkeypatch.setattr("jax.devices", none)
    monkeypatch.setattr("acf_jax.start.start_jax", check_devices)
    for module in ("validation.blind.campaign", "acf_jax.fleet.run"):
        monkeypatch.setattr(f"{module}.run_all", started)
    code, text, error = end(*path, *arguments)
    if path in (("import",), ("blind", "seal"), ("export",)):  # what they do here needs no JAX
        assert code == 0 and not error
    else:
        assert code == 2 and not text and not (tmp_path / "out/diagnosis.json").exists()
        assert error.splitlines()[-1].startswith(
            "error: JAX_PLATFORMS='cuda': JAX has no such device here; unset"
        )
        assert error.count("error:") == 1


@ANSWERING
def test_json_and_nothing_else_on_standard_output(path, end, monkeypatch, tmp_path):
    if path in (("blind",), ("blind", "score"), ("design",)):
        return  # tests/validation/blind/test_run.py, tests/cli/test_design_and_check.py
    arguments = prepared(path, tmp_path)
    monkeypatch.setattr(
        "acf_jax.fleet.run.run_all", lambda work, pieces, _: ((key, work(piece)) for key, piece in pieces)
    )
    with few_explanations(("end_stop",), ()):
        code, text, error = end(*path, *arguments)
    assert code in (0, 1), error
    json.loads(text, parse_constant=pytest.fail)


def test_names_that_are_no_text(end, monkeypatch, tmp_path):
    """A path may hold bytes that no encoding knows; standard output may know fewer letters than a path."""
    folder = tmp_path / os.fsdecode(b"caf\xe9 \xe2\x82\xac")
    folder.mkdir()
    shutil.copy(RIG, folder / "rig.yaml")
    shutil.copy(ROOT / "examples/rig_surrogate.eqx", folder)
    code, _, error = end("export", "--surrogate", folder / "rig_surrogate.eqx", "--c", folder / "force.h")
    assert code == 0 and not error and (folder / "force.h").read_text()
    told = io.TextIOWrapper(io.BytesIO(), encoding="latin-1")
    with monkeypatch.context() as patch:
        patch.setattr("sys.stdout", told)
        code, _, error = end("identify", ROOT / "configs/table1.csv", "--rig", folder / "rig.yaml")
    told.seek(0)
    assert code == 0 and not error and "caf\\udce9 \\u20ac" in told.read()


def test_a_link_stays_one_and_what_is_no_file_is_not_replaced(end, tmp_path):
    link, pipe = tmp_path / "link.h", tmp_path / "pipe.h"
    link.symlink_to("real.h")
    os.mkfifo(pipe)
    assert end("export", "--c", link)[0] == 0
    assert link.is_symlink() and "acf_find_peak" in (tmp_path / "real.h").read_text()
    code, text, error = end("export", "--c", pipe)
    assert code == 2 and not text and is_one_message(error) and f"{pipe}: is not an ordinary file" in error
    assert pipe.is_fifo()


def test_a_folder_in_place_of_a_result_is_named(end, tmp_path):
    arguments = prepared(("predict",), tmp_path)
    (tmp_path / "out/predictions.csv").mkdir(parents=True)
    code, text, error = end("predict", *arguments)
    assert (
        code == 2 and not text and is_one_message(error) and f"{tmp_path / 'out/predictions.csv'}: " in error
    )


@pytest.mark.parametrize("which, shown, noted", [
    ("corrected", False, True), (None, False, True), ("recalibrated", False, False), ("corrected", True, False),
    ("corrected", None, False),
])  # fmt: skip
def test_a_prediction_says_where_nothing_shows_that_the_correction_helps(end, tmp_path, which, shown, noted):
    arguments = prepared(("predict",), tmp_path)
    model = gap_model().model_copy(update={"shown_closer": shown})
    (tmp_path / "model/model.json").write_text(write_model(model))
    code, _, error = end("predict", *arguments, *(["--model", which] if which else []))
    assert code == 0 and ("compare with the recalibrated model" in error) == noted


@pytest.mark.parametrize("hertz, says", [
    ("0", "--low-pass"),
    ("-200", "--low-pass"),
    ("nan", "low-pass: cutoff_hz must be a finite number"),
    ("20", "give at least"),
    ("1e5", "give less than half of that"),
])  # fmt: skip
def test_a_filter_that_cannot_be_is_one_message(end, tmp_path, hertz, says):
    code, text, error = end("diagnose", ROOT / "examples/rig", "--out", tmp_path / "out", "--low-pass", hertz)
    assert code == 2 and not text and not list(tmp_path.iterdir())
    assert says in error and "Traceback" not in error


def test_a_plan_behind_a_filter_that_cannot_be_is_one_message(end, tmp_path):
    text = (ROOT / "examples/rig/dataset.yaml").read_text()
    assert text.rstrip().splitlines()[-1].startswith("  ")  # of the measurement
    (tmp_path / "dataset.yaml").write_text(text.rstrip() + "\n  low_pass: {cutoff_hz: 20}\n")
    conditions = ROOT / "examples/rig/held_out_conditions.csv"
    code, text, error = end("plan", tmp_path / "dataset.yaml", "--conditions", conditions)
    assert code == 2 and not text and is_one_message(error)
    assert "dataset.yaml: measurement.low_pass: cutoff_hz is 20 Hz" in error and "give at least" in error


def test_peaks_are_on_the_terminal(end, tmp_path):
    prepared(("predict",), tmp_path)
    asked = tmp_path / "asked.csv"
    rows = [f"t{i:02},{0.1 + 0.01 * i:.2f},60" for i in range(22)]
    asked.write_text("\n".join(["trial,contact_velocity_m_per_s,pretension_n", *rows, ""]))
    out = str(tmp_path / "other")
    code, text, _ = end("predict", tmp_path / "model", "--conditions", asked, "--out", out)
    head, *lines, rest, last = text.splitlines()
    written = read_rows(tmp_path / "other/predictions.csv")
    assert code == 0 and "at the contact" in head and "sensed" in head and len(lines) == 20
    assert rest == "and 2 more" and last.endswith("predictions.csv: 22 impacts by the corrected model")
    for line, row in zip(lines, written, strict=False):
        name, *values = line.replace("±", "").split()
        columns = ("contact_peak_force_n", "contact_peak_force_std_n", "peak_force_n", "peak_force_std_n")
        assert name == row["trial"]
        assert [float(x) for x in values] == pytest.approx([float(row[c]) for c in columns], abs=0.0051)


@pytest.mark.parametrize("words, says", [
    (["diagnos"], "no such command 'diagnos'; did you mean 'diagnose'?"),
    (["Imprt", "x.csv"], "no such command 'Imprt'; did you mean 'import'?"),
    (["blind", "seel"], "no such command 'seel'; did you mean 'seal'?"),
    (["frobnicate"], "no such command 'frobnicate'; known are app, blind, check, design, diagnose, export, fleet,"),
    ([""], "no such command ''; known are app, blind,"),
])  # fmt: skip
def test_a_misspelt_command_gets_a_suggestion(end, words, says):
    code, text, error = end(*words)
    assert code == 2 and not text and is_one_message(error) and says in error


@pytest.mark.parametrize("which, used, says", [
    (None, "recalibrated", "this is the recalibrated one's prediction"),
    ("corrected", "corrected", "take that one"),
    ("recalibrated", "recalibrated", None),
])  # fmt: skip
def test_a_prediction_is_not_by_a_correction_that_is_no_better(end, tmp_path, which, used, says):
    arguments = prepared(("predict",), tmp_path)
    model = gap_model().model_copy(update={"better": False, "shown_closer": False})
    (tmp_path / "model/model.json").write_text(write_model(model))
    code, text, error = end("predict", *arguments, *(["--model", which] if which else []))
    assert code == 0 and json.loads(text)["model"] == used
    assert ("is not better than the recalibrated one" in error and says in error) if says else not error


def prepared(path: tuple[str, ...], folder: Path) -> list[str]:
    """The arguments of a command whose files are there."""
    arguments = ANSWERS[" ".join(path)]
    if path[-1] in ("predict", "train"):
        (folder / "model").mkdir()
        (folder / "model/model.json").write_text(write_model(gap_model()))
    if path[0] == "fleet" or (path[0] == "blind" and path[1:]):
        shutil.copytree(ROOT / "examples/rig", folder / "sets/rig")
        shutil.copy(ROOT / "examples/rig_answer.yaml", folder / "sets/rig/answer.yaml")
    return ["--json", *(str(a).replace("FOLDER", str(folder)) for a in arguments)]


def read_rows(path: Path) -> list[dict[str, str]]:
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


def files(folder: Path) -> list[Path]:
    return sorted(file for file in folder.rglob("*") if file.is_file())
