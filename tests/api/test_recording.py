"""A recording in Python: the same data set as the command's, trials dropped by hand, what cannot be used."""

import shutil
from dataclasses import replace

import numpy as np
import pytest
import yaml

import acf_jax as acf
from acf_jax.cli.main import main
from acf_jax.dataset import GapDataset
from acf_jax.dataset import read_dataset as read_as_files
from acf_jax.errors import InputError
from tests.api.conftest import KNOWN, SIGNALS
from tests.recording.sessions import CONDITIONS, RIG, made

EVIL = "<img src=x onerror=\"document.title='owned'\">"


def opened(path, **changes):
    return acf.read_recording(path, **SIGNALS | changes)


def same_trials(one: GapDataset, other: GapDataset) -> None:
    assert [(t.name, t.condition, t.peak_force) for t in one.trials] == [
        (t.name, t.condition, t.peak_force) for t in other.trials
    ]
    for a, b in zip(one.trials, other.trials, strict=True):
        np.testing.assert_array_equal(a.trace.time, b.trace.time)
        np.testing.assert_array_equal(a.trace.force, b.trace.force)


def test_the_data_set_is_that_of_the_command(press, tmp_path, capsys):
    (tmp_path / "rig.yaml").write_text(RIG)
    (tmp_path / "map.yaml").write_text(yaml.safe_dump({"contacts": {"tare": True}}))
    options = [f"--{name}={SIGNALS[name]}" for name in ("force", "velocity", "pretension", "time")]
    with pytest.raises(SystemExit) as end:
        main(["import", str(press), "--out", str(tmp_path / "set"), "--rig", str(tmp_path / "rig.yaml"),
              "--mapping", str(tmp_path / "map.yaml"), *options])  # fmt: skip
    assert end.value.code == 0
    session = opened(press)
    assert repr(session).splitlines()[0].endswith(capsys.readouterr().out.splitlines()[0])
    by_command, here = read_as_files(tmp_path / "set"), session.dataset(acf.Prior(**KNOWN))
    assert len(here.trials) == len(CONDITIONS) and here.rig == by_command.rig
    assert here.measurement == by_command.measurement and here.folder == press
    same_trials(here, by_command)
    same_trials(
        opened(press, rig=tmp_path / "rig.yaml").dataset(), by_command
    )  # the rig beside the recording
    same_trials(
        opened(press, tare=None, mapping=str(tmp_path / "map.yaml")).dataset(tmp_path / "rig.yaml"), here
    )


def test_sign_and_offset_are_taken_care_of(recording):
    """The table reads minus the force and 7 N; conditions are those that were made."""
    data = recording.dataset(acf.Prior(**KNOWN))
    for trial, (v_e, f_p) in zip(data.trials, made().impacts, strict=True):
        assert trial.contact_velocity == pytest.approx(v_e, rel=0.02) and trial.pretension == pytest.approx(
            f_p
        )
        assert abs(np.median(trial.trace.force[trial.trace.time < 0])) < 0.5


def test_dropped_is_left_out_and_kept_again_is_as_before(press):
    session = opened(press)
    before = session.dataset(acf.Prior(**KNOWN))
    assert session.drop("t011", "t003") is session
    names = {t.name for t in session.dataset(acf.Prior(**KNOWN)).trials}
    assert len(names) == 10 and not names & {"t003", "t011"} and session.trials == tuple(sorted(names))
    assert "t011 is not kept: dropped by hand" in repr(session)
    session.drop("t011").keep("t003", "t011")
    assert session.trials == tuple(t.name for t in before.trials)
    same_trials(session.dataset(acf.Prior(**KNOWN)), before)


def test_a_file_of_cuts_and_what_a_rig_file_says_of_measuring_count_as_for_the_command(press, tmp_path):
    rig, cuts = tmp_path / "rig.yaml", tmp_path / "cuts.yaml"
    rig.write_text(RIG + "measurement: {force_noise_std_n: 0.9}\n")
    given = [f"--{name}={SIGNALS[name]}" for name in ("force", "velocity", "pretension", "time")]
    command = [
        "import",
        str(press),
        "--out",
        str(tmp_path / "set"),
        "--rig",
        str(rig),
        "--review",
        str(cuts),
        *given,
    ]

    def run() -> None:
        with pytest.raises(SystemExit) as end:
            main(command)
        assert end.value.code == 0

    run()
    content = yaml.safe_load(cuts.read_text())
    content["cuts"][1]["keep"] = False
    content["cuts"][2] |= {"keep": True, "contact_s": content["cuts"][2]["contact_s"] + 1e-3}
    cuts.write_text(yaml.safe_dump(content))
    run()
    by_command, session = read_as_files(tmp_path / "set"), opened(press, rig=rig, review=cuts)
    here = session.dataset()
    assert here.measurement == by_command.measurement and here.measurement.force_noise_std_n == 0.9
    assert len(here.trials) == len(CONDITIONS) - 1
    same_trials(here, by_command)
    assert len(session.drop("t004").dataset().trials) == len(here.trials) - 1  # beside what the file decides
    with pytest.raises(InputError, match=r"cuts\.yaml"):
        opened(shutil.copy(press, tmp_path / "other.csv"), review=cuts)


def test_what_it_shows(recording, press):
    whole, one = recording.plot(), recording.plot("t003")
    assert {trace.name for trace in whole.data} == {"force", "kept", "velocity"}
    assert sum(shape.type == "rect" for shape in whole.layout.shapes) == len(CONDITIONS)
    cut = recording.impacts.kept[3]
    np.testing.assert_allclose(one.data[0].x, 1e-6 * cut.time, rtol=1e-6, atol=1e-9)
    assert not any(
        str(value).startswith("--") for value in (whole.data[0].line.color, one.layout.shapes[0].line.color)
    )
    html = recording._repr_html_()
    assert (
        html.count("<tr>") == 1 + len(CONDITIONS)
        and "press.csv" in html
        and "-1*Fz" not in html.split("<table>")[1]
    )


@pytest.mark.parametrize("ask, says", [
    (lambda s: s.drop("t11"), "'t11' is no trial of the recording; did you mean 't011'?"),
    (lambda s: s.drop("x", "t000"), "'x' is no trial of the recording; known are t000 to t011"),
    (lambda s: s.keep("t099"), "'t099' is no trial of the recording"),
    (lambda s: s.plot("t1"), "'t1' is no trial of the recording"),
    (lambda s: s.dataset(), "rig: is missing; give what is known of it"),
    (lambda s: acf.diagnose(s), "rig: is missing; give what is known of it"),
    (lambda s: s.dataset("none.yaml"), "none.yaml: no such file"),
    (lambda s: s.dataset(acf.Rig(4.0, 60.0, 2e3, 1.7e5)), "rig: a diagnosis needs standard deviations"),
])  # fmt: skip
def test_what_cannot_be_asked_is_told_and_changes_nothing(recording, ask, says):
    with pytest.raises(InputError) as told:
        ask(recording)
    assert told.value.faults[0].startswith(says)
    assert len(recording.trials) == len(CONDITIONS)


@pytest.mark.parametrize("change, says", [
    ({"force": "-1*Fx"}, "Fx"),
    ({"velocity": None}, "name it by velocity=, or a position by position=; where it is in a recording of its own"),
    ({"time": "tt"}, "tt"),
    ({"velocity": True}, "velocity: "),
    ({"rate": -1.0, "time": None}, "rate: "),
    ({"tare": "yes"}, "tare: must be True or False, but is 'yes'"),
    ({"position": "v_mm_s"}, "velocity and position are both given"),
    ({"mapping": "none.yaml"}, "none.yaml: no such file"),
])  # fmt: skip
def test_faults_name_the_argument_without_dashes(press, change, says):
    with pytest.raises(InputError) as told:
        opened(press, **change)
    assert any(says in fault for fault in told.value.faults), told.value.faults
    assert not any(fault.startswith("--") for fault in told.value.faults)


def test_a_recording_of_no_use_is_shown_all_the_same(press):
    """Without the sign: the force falls in contact."""
    with pytest.warns(UserWarning, match="is negative in contact") as told:
        session = opened(press, force="Fz")
    assert told[0].filename == __file__
    assert session.faults and "no data set" in repr(session) and "before its name" in session._repr_html_()
    assert len(session.plot().data) >= 2
    with pytest.raises(InputError, match="put -1\\* before its name"):
        session.dataset(acf.Prior(**KNOWN))


def test_too_many_dropped_are_warned_of_at_once(press):
    session = opened(press)
    with pytest.warns(UserWarning, match="2 of 12 contacts can be used") as told:
        session.drop(*session.trials[2:])
    assert told[0].filename == __file__
    session.keep("t002")
    assert not session.faults and len(session.trials) == 3


def test_a_data_set_shows_itself_and_nothing_of_it_is_html(recording, tmp_path):
    data = recording.dataset(acf.Prior(**KNOWN))
    trials = [replace(trial, name=f"{trial.name}{EVIL}") for trial in data.trials]
    evil = replace(data, description=EVIL, trials=tuple(trials))
    assert type(evil) is type(data) and "<img" not in evil._repr_html_() and "&lt;img" in evil._repr_html_()
    figure = evil.plot()
    assert len(figure.data) == len(CONDITIONS) and len(figure.layout.updatemenus[0].buttons) == 6
    assert not any("<img" in trace.name for trace in figure.data)
    words = repr(data).splitlines()
    assert (
        words[0].endswith("12 trials at 6 conditions, 12 with a trace")
        and "pretension 60 to 100 N" in words[1]
    )
    bare = replace(data, trials=tuple(replace(t, trace=None) for t in data.trials))
    with pytest.raises(InputError, match="holds peaks only"):
        bare.plot()
    assert "0 with a trace" in repr(bare)


def test_names_of_a_review_may_be_odd_in_a_figure(recording):
    odd = replace(recording.impacts.cuts[0], trial="<b>x</b>")
    shown = acf.api.recording.to_plotly(
        acf.api.recording.each_cut(replace(recording.impacts, cuts=(odd, odd)))
    )
    assert "<b>" not in shown.layout.updatemenus[0].buttons[0].label
