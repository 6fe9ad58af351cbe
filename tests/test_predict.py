"""What a gap model predicts at conditions that no trial had."""

from pathlib import Path

import numpy as np
import pytest

from acf_jax.effects import library
from acf_jax.errors import InputError
from acf_jax.gap_model import forms, read_model, write_model
from acf_jax.predict import Prediction, notes, predict
from tests.corrected import gap_model
from tests.corrected import variant as made
from tests.typical import typical


def test_where_a_free_curve_goes_astray_the_recalibrated_model_predicts() -> None:
    model = gap_model(("unknown_contact",), tuple(typical("unknown_contact")))
    near, far = np.array([0.1, 20.0]), np.array([60.0, 60.0])
    held, gone = predict(model, near, far)
    assert gone.diverges and not held.diverges
    instead = predict(model, near, far, "recalibrated")[1]
    assert not instead.diverges
    assert gone.peak_force == instead.peak_force
    assert np.array_equal(gone.contact_force, instead.contact_force)


def test_conditions_beyond_the_trials_are_noted_once() -> None:
    model = gap_model()  # 0.05 to 0.35 m/s, 50 to 90 N
    assert notes(model, np.array([0.05, 0.35]), np.array([50.0, 90.0])) == []
    (note,) = notes(model, np.array([0.2, 0.4, 0.2]), np.array([60.0, 60.0, 95.0]))
    assert note.startswith("2 of 3 impacts lie beyond the trials") and "v_e = 0.4 m/s lies outside" in note


def test_what_a_free_curve_does_after_contact_is_lost_says_nothing() -> None:
    # a push that grows with the cube of the stroke breaks the simulation down when the flange has left the part
    model = gap_model(("unknown_actuator",), tuple(typical("unknown_actuator", stroke_3_n=300.0)))
    (away,) = predict(model, np.array([0.1]), np.array([60.0]))
    assert not away.diverges
    assert away.time[-1] < 0.02
    assert np.isfinite([*away.force, *away.contact_force, away.peak_force_std]).all()


def test_the_contact_force_of_a_sensor_with_wrong_gain_is_as_uncertain_as_the_rig() -> None:
    """What is known is the reading (1 + e) F: of the contact force that says as little as of the gain e."""
    model = gap_model(("sensor_scale",), (0.2,))
    v, where = model.corrected, (np.array([0.3]), np.array([60.0]))
    step = np.array([0.0, 0.0, 0.0, 8e3, -0.06])  # a stiffer contact that is read as less

    def with_rig(**changed: object) -> Prediction:
        return predict(model.model_copy(update={"corrected": v.model_copy(update=changed)}), *where)[0]

    here = with_rig(covariance=tuple(map(tuple, np.outer(step, step).tolist())))
    there = with_rig(theta=tuple(np.array(v.theta) + step))
    assert here.contact_peak_force_std == pytest.approx(
        there.contact_peak_force - here.contact_peak_force, rel=0.1
    )
    assert here.peak_force_std < 0.5 * here.contact_peak_force_std


def test_an_alternative_that_breaks_down_adds_no_spread() -> None:
    broken = made(("unknown_contact",), tuple(typical("unknown_contact")), 0.4)
    near, far = np.array([0.1, 20.0]), np.array([60.0, 60.0])
    alone, beside = predict(gap_model(), near, far), predict(gap_model(alternatives=(broken,)), near, far)
    assert beside[1].peak_force_std == pytest.approx(alone[1].peak_force_std)
    assert beside[0].peak_force_std > 1.1 * alone[0].peak_force_std


@pytest.mark.parametrize("delay", [1.5e-4, -1.5e-4])
def test_a_delay_of_the_reading_leaves_the_contact_force(delay: float) -> None:
    punctual = gap_model(("sensor_lag",), (5e-4, 0.8))
    late = punctual.model_copy(update={"corrected": punctual.corrected.model_copy(update={"delay_s": delay})})
    one, other = (predict(m, np.array([0.2]), np.array([60.0]), sample_rate=2e5)[0] for m in (punctual, late))
    inner = (one.time > 2e-4) & (one.time < one.time[-1] - 2e-4)
    expected = np.interp(one.time[inner] - delay, one.time, one.force)
    assert other.force[inner] == pytest.approx(expected, abs=0.01)
    assert other.force[0] == one.force[0] < 1.0  # at first contact a lagging sensor reads nothing yet
    assert other.contact_force == pytest.approx(one.contact_force)
    assert other.peak_time == pytest.approx(one.peak_time + delay, abs=5e-6)


def test_an_early_reading_ends_with_the_simulation() -> None:
    def early_by(delay: float) -> Prediction:
        model = gap_model(("sensor_lag",), (5e-4, 0.8))
        m, _, _, *more = model.corrected.theta
        # so stiff and damped a flange that contact is held to the end
        held = {"theta": (m, 2000.0, 8e4, *more), "delay_s": -delay}
        corrected = model.corrected.model_copy(update=held)
        return predict(model.model_copy(update={"corrected": corrected}), np.array([0.2]), np.array([60.0]))[
            0
        ]

    punctual, early = early_by(0.0), early_by(0.01)
    assert early.time[-1] == punctual.time[-1] == pytest.approx(0.06)
    assert early.force.max() <= punctual.force.max() * 1.01


def test_a_file_of_a_version_whose_friction_had_other_parameters_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "model.json"
    text = write_model(gap_model(("coulomb_friction",), (10.0, 0.03, 0.02)))
    path.write_text(text)
    assert read_model(path).corrected.theta[4:] == (10.0, 0.03, 0.02)
    path.write_text(text.replace("coulomb_friction.coefficient", "coulomb_friction.stribeck_n"))
    with pytest.raises(InputError) as error:
        read_model(path)
    assert error.value.faults == [
        f"{path}: corrected.names: this version knows no 'coulomb_friction.stribeck_n'; diagnose the data again, which"
        " writes the file anew"
    ]


def test_a_model_whose_law_has_changed_since_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path, model = tmp_path / "model.json", gap_model(("coulomb_friction",), (10.0, 0.03, 0.02))
    fitted = model.corrected.model_copy(update={"forms": forms(("coulomb_friction",))})
    path.write_text(write_model(model.model_copy(update={"corrected": fitted})))
    assert read_model(path).corrected.forms == (1,)
    monkeypatch.setattr(library()["coulomb_friction"], "form", 2)
    with pytest.raises(InputError, match="corrected: was fitted with another form of coulomb_friction than"):
        read_model(path)
    many = fitted.model_copy(update={"forms": (1, 1)})
    path.write_text(write_model(model.model_copy(update={"corrected": many})))
    with pytest.raises(InputError, match=r"corrected\.forms: holds 2 numbers for 1 effects"):
        read_model(path)
