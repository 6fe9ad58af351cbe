"""Verdicts: what is allowed, what is not, and what cannot be decided."""

from collections.abc import Callable
from pathlib import Path

import jax
import numpy as np
import pytest

from acf_jax.contact.ending import OPEN, Ending
from acf_jax.contact.model import ContactModel, draw_forces
from acf_jax.contact.read import of_diagnosis, of_rig
from acf_jax.dataset.tried import Tried
from acf_jax.errors import InputError
from acf_jax.safety.assumptions import assumptions
from acf_jax.safety.check import FASTER, Checker
from acf_jax.safety.limits import BodyArea, body_of, limits_of, read_limits
from acf_jax.safety.situation import Situation, read_situations
from acf_jax.surrogate import load_surrogate
from tests.corrected import gap_model, variant

RIG = {"m": 1.9, "d": 60.0, "k_f": 800.0, "k_c": 6e4}
STD = {"m": 0.02, "k_c": 0.05, "v_e": 0.005, "f_p": 0.01}
LIMITS = read_limits()
STOP = Ending(stop_after=0.02)


@pytest.fixture(scope="module")
def checker() -> Checker:
    return Checker(of_rig(RIG, STD), load_surrogate())


def situation(
    name: str = "Deltoid muscle", contact: str = "transient", v: float = 0.2, f: float = 60.0, **more: object
) -> Situation:
    return Situation("", LIMITS.find(name), contact, v, f, **more)  # type: ignore[arg-type]


def test_verdicts_on_either_side_of_the_limit_and_between(checker: Checker) -> None:
    s = situation(contact="quasi_static", ending=STOP)
    top = checker.highest_speed(s).v
    assert top is not None and checker(s._replace(v_e=top)).verdict == "allowed"
    above = checker(s._replace(v_e=top * 1.001))
    assert above.verdict == "not decidable" and "confidence" in above.reasons[0]
    assert above.force is not None and above.force < 150 < (above.upper or 0.0)
    over = checker(s._replace(v_e=2 * top))
    assert over.verdict == "not allowed" and over.force is not None and over.force > 150


def test_a_bound_that_comes_with_the_surrogate_is_that_asked_alone(checker: Checker) -> None:
    x = np.array([*checker.theta, 0.2, 60.0, 4e-5, 0.0, *STOP])
    assert checker.quick is not None and checker.bound is not None
    (*_, along), (alone,) = checker.quick(x), checker.bound(x)
    assert along.is_known and along == pytest.approx(alone)


def test_factor_belongs_to_the_limit_and_not_to_the_force(checker: Checker) -> None:
    clamped, free = situation(contact="quasi_static"), situation()
    (area,) = free.areas
    assert limits_of(area, "quasi_static") == (150, 190) and limits_of(area, "transient") == (300, 380)
    assert body_of(area, "quasi_static").mobility == 0
    assert body_of(area, "transient").mobility == pytest.approx(1 / 3)
    a, b = checker(clamped), checker(free)
    assert a.force is not None and b.force is not None and b.force < a.force


def test_the_standards_formula_is_for_a_body_that_recoils_and_the_lower_limit(checker: Checker) -> None:
    masses = {"moving_mass": 20.0, "payload": 7.0}
    free = checker(situation(**masses)).standard_speed
    small = checker(situation(contact_area=0.3, **masses)).standard_speed  # 380 N/cm^2 of 0.3 cm^2
    assert free is not None and small == pytest.approx(free * 114 / 300)
    assert checker(situation(contact="quasi_static", **masses)).standard_speed is None
    slow, fast = (checker(situation(v=share * free, **masses)) for share in (0.99, 1.01))
    assert FASTER in fast.cautions and FASTER not in slow.cautions


def test_the_scatter_of_the_trials_counts() -> None:
    gap = gap_model()
    upper = [
        Checker(of_diagnosis(gap.model_copy(update={"rel_std": scatter})))(situation(v=0.2, f=70.0)).upper
        for scatter in (None, (0.005, 0.005), (0.05, 0.005))
    ]
    assert upper[0] == upper[1] and upper[2] > upper[1] + 0.5


@pytest.mark.parametrize("name", ["Middle of forehead", "Temple", "Face", "skull and forehead"])
@pytest.mark.parametrize("contact", ["transient", "quasi_static"])
def test_head_and_face_are_never_allowed(checker: Checker, name: str, contact: str) -> None:
    answer = checker(situation(name, contact, v=0.0, f=0.0))
    assert answer.verdict == "not allowed" and answer.decided_by == "rule"


def test_pressure_decides_with_an_area_and_is_not_decided_without(checker: Checker) -> None:
    assert checker(situation("Sternum")).pressure is None
    small = checker(situation("Sternum", contact_area=0.2))
    assert small.verdict == "not allowed" and "pressure" in small.reasons[0]
    large = checker(situation("Sternum", contact_area=5.0))
    assert large.verdict == "allowed" and large.pressure == pytest.approx((large.upper or 0.0) / 5)


def test_nothing_is_allowed_by_extrapolation() -> None:
    tried = Checker(of_rig(RIG, STD, None, Tried((0.05, 0.3), (50.0, 90.0))))
    assert tried(situation(v=0.2)).verdict == "allowed"
    for s in (situation(v=0.31), situation(v=0.01), situation(f=91.0)):
        answer = tried(s)
        assert answer.verdict == "not decidable" and "extrapolation" in answer.reasons[0]
    assert (
        tried.highest_speed(situation("Palm (dominant side)")) == (0.3, "tried range") and not answer.cautions
    )
    untried = Checker(of_rig(RIG, {}))
    assert untried.highest_speed(situation("Palm (dominant side)"), up_to=0.4) == (0.4, "search")
    assert "range unknown" in untried(situation()).cautions[0]
    soft = {"m": 0.6, "d": 5.0, "k_f": 0.0, "k_c": 2000.0}
    fast = Checker(of_rig(soft, {}, tried=Tried((2.2, 4.4), (0.0, 5.0))))
    assert fast.highest_speed(situation("Palm (dominant side)", f=2.0)) == (4.4, "tried range")


def test_speed_and_pretension_must_have_been_tried_together() -> None:
    corners = ((0.05, 50.0), (0.05, 90.0), (0.3, 50.0))
    tried = Tried((0.05, 0.3), (50.0, 90.0), corners)
    assert tried.speeds_at(60.0) == pytest.approx((0.05, 0.2375)) and tried.speeds_at(90.0) == (0.05, 0.05)
    rig = Checker(of_rig(RIG, STD, None, tried))
    assert rig(situation(v=0.2)).verdict == "allowed"
    answer = rig(situation(v=0.25))
    assert answer.verdict == "not decidable" and "only 0.05 to 0.2375 m/s" in answer.reasons[0]
    v, end = rig.highest_speed(situation("Palm (dominant side)"))
    assert end == "tried range" and v == pytest.approx(0.2375)


def test_a_force_without_a_first_peak_is_not_decidable() -> None:
    stuck = Checker(of_rig({"m": 4.0, "d": 1200.0, "k_f": 9000.0, "k_c": 2e4}, {}), load_surrogate())
    answer = stuck(situation(v=0.8, f=10.0))
    assert answer.verdict == "not decidable" and answer.force is None


@pytest.mark.parametrize("ending", [OPEN, STOP])
def test_surrogate_and_exact_model_agree_and_the_exact_one_decides_near_the_limit(
    checker: Checker, ending: Ending
) -> None:
    exact = Checker(checker.model)
    deciders = set()
    for v in (0.05, 0.2, 0.4, 0.8, 1.6):
        for name in ("Deltoid muscle", "Sternum", "Palm (dominant side)"):
            s = situation(name, "transient" if ending == OPEN else "quasi_static", v=v, ending=ending)
            a, b = checker(s), exact(s)
            assert a.verdict == b.verdict and a.upper == pytest.approx(b.upper, rel=1e-4)
            assert (a.upper or 0) >= (b.upper or 0) * (1 - 1e-4)
            deciders.add(a.decided_by)
    assert "surrogate" in deciders
    s = situation(contact="quasi_static", ending=STOP)
    near = checker(s._replace(v_e=checker.highest_speed(s).v or 0.0))
    assert near.decided_by == "exact model"


def test_further_situations_do_not_compile_again(checker: Checker) -> None:
    checker(situation())
    checker(situation("Kneecap", "quasi_static", f=70.0))  # until when the robot must have stopped, too
    with jax.log_compiles(), pytest.MonkeyPatch.context() as patch:
        patch.setattr("jax._src.compiler.compile_or_get_cached", None)  # compiling would fail
        for v in (0.11, 0.12):
            checker(situation("Kneecap", "quasi_static", v=v, f=70.0))


def corrected() -> ContactModel:
    return of_diagnosis(gap_model())


def test_corrected_model_checks_the_contact_force_not_the_sensors() -> None:
    model = corrected()
    answer = Checker(model, load_surrogate())(situation(v=0.2, f=70.0, ending=STOP))
    assert answer.verdict == "allowed" and answer.decided_by == "simulation"
    assert Checker(model)(situation(v=0.5, f=70.0, ending=STOP)).verdict == "not decidable"
    (area,) = situation().areas
    said = "\n".join(assumptions(model, situation(), area, 0.975))
    assert "no sensor's reading" in said and "30 N/mm act in series" in said and "21.8 N/mm in all" in said


def area(**values: float | str | None) -> BodyArea:
    return LIMITS.find("22")[0]._replace(**values)


def test_the_worst_of_all_areas_that_a_name_means_decides(checker: Checker) -> None:
    back = area(name="Back", force=100.0, pressure=None, pressure_factor=None)
    finger = area(name="Finger", force=110.0, pressure=50.0, force_factor=1.0, pressure_factor=1.0)
    s = Situation("", (back, finger), "transient", 0.5, 60.0, contact_area=1.0)
    assert checker(s._replace(areas=(back,))).verdict == "allowed"
    for areas in ((back, finger), (finger, back)):
        answer = checker(s._replace(areas=areas))
        assert answer.verdict == "not allowed" and answer.area.name == "Finger"
    face = checker(s._replace(areas=(back, LIMITS.find("face")[0])))
    assert face.verdict == "not allowed" and face.decided_by == "rule"


def test_a_pretension_above_the_lasting_limit_is_not_decidable(checker: Checker) -> None:
    answer = checker(situation("Palm (dominant side)", v=0.05, f=250.0))
    assert answer.verdict == "not decidable" and "lasting limit of 140 N" in answer.reasons[0]
    # 139 N by themselves, but up to 141.7 N with their uncertainty
    assert checker(situation("Palm (dominant side)", v=0.05, f=139.0)).verdict == "not decidable"
    assert checker(situation("Palm (dominant side)", v=0.05, f=136.0)).verdict == "allowed"
    pressed = checker(situation("Palm (dominant side)", v=0.05, f=100.0, contact_area=0.35))
    assert pressed.verdict == "not decidable" and "lasting limit of 260 N/cm^2" in pressed.reasons[0]
    over = checker(situation("Palm (dominant side)", v=0.2, f=290.0, contact_area=1.0))
    assert over.verdict == "not allowed" and "force" in over.reasons[0]
    assert over.pressure_verdict == "not decidable"  # 297 of 520 N/cm^2, but 290 of 260 N/cm^2 stay


@pytest.mark.parametrize("effect, values", [("gravity", (-30.0,)), ("pretension_error", (0.25, 0.0, 3.0))])
def test_what_a_corrected_model_presses_with_counts_when_the_impact_is_over(
    effect: str, values: tuple[float, ...]
) -> None:
    checker = Checker(
        of_diagnosis(gap_model((effect,), values).model_copy(update={"f_p_range": (50.0, 150.0)}))
    )
    palm = situation("Palm (dominant side)", v=0.05, f=125.0, ending=STOP)
    for contact in ("transient", "quasi_static"):
        answer = checker.judge(palm._replace(contact=contact))
        assert answer.verdict != "allowed" and "limit of 140 N" in answer.reasons[0]
        assert checker.judge(palm._replace(contact=contact, f_p=90.0)).verdict == "allowed"


@pytest.mark.parametrize(
    "wrong",
    [
        {"v_e": -3.0}, {"v_e": np.nan}, {"v_e": np.inf}, {"v_e": 250.0}, {"f_p": -100.0}, {"f_p": 0.06},
        {"contact_area": -1.0}, {"contact_area": 0.0}, {"contact_area": np.nan}, {"contact_area": 2e4},
        {"contact": "quasi-static"}, {"moving_mass": 20.0}, {"areas": ()},
    ],
)  # fmt: skip
def test_a_situation_that_cannot_be_is_refused(checker: Checker, wrong: dict[str, object]) -> None:
    with pytest.raises(ValueError, match=next(iter(wrong))):
        checker(situation()._replace(**wrong))


def test_a_checker_refuses_single_precision_and_an_odd_confidence() -> None:
    for confidence in (0.01, 0.99999, np.nan):
        with pytest.raises(ValueError, match="confidence"):
            Checker(of_rig(RIG, {}), confidence=confidence)
    with jax.enable_x64(False), pytest.raises(ValueError, match="double precision"):
        Checker(of_rig(RIG, {}))


def test_a_diagnosis_verdict_weakens_the_checks() -> None:
    def ask(verdict: str) -> tuple[str, tuple[str, ...]]:
        gap = gap_model().model_copy(update={"verdict": verdict})
        answer = Checker(of_diagnosis(gap))(situation(v=0.2, f=70.0, ending=STOP))
        return answer.verdict, (*answer.reasons, *answer.cautions)

    assert ask("identified")[0] == "allowed" and len(ask("identified")[1]) == 1
    verdict, said = ask("unknown")
    assert verdict == "allowed" and "fitted freely" in said[1]
    verdict, said = ask("insufficient_data")
    assert verdict == "not decidable" and "too little data" in said[0]


def exceeded(checker: Checker, s: Situation, draws: int, seed: int = 1) -> float:
    """The share of drawn forces above what the check says is not exceeded."""
    upper, z, body = checker(s).upper, checker.model.at(s.v_e, s.f_p), body_of(s.areas[0], s.contact)
    found, exists = draw_forces(checker.model, z, body, draws, seed)
    return float(((found > (upper or 0.0)) | ~exists).mean())


@pytest.mark.parametrize("weight", [0.05, 0.49])
def test_confidence_holds_over_a_second_explanation(weight: float) -> None:
    """The other's force is far above the main one's: by gravity, 60 N instead of 8 N."""
    gap = gap_model(alternatives=(variant(("gravity",), (-60.0,), weight),))
    main = gap.corrected.model_copy(update={"probability": 1 - weight})
    checker = Checker(of_diagnosis(gap.model_copy(update={"corrected": main})))
    s = situation("Palm (dominant side)", "quasi_static", 0.2, 70.0)
    assert 0.012 < exceeded(checker, s, 2000) < 0.0355, "three standard errors on either side"
    above = s._replace(areas=(area(force=(checker(s).force or 0.0) + 5.0),))
    assert checker(above).verdict == "not decidable"


def test_a_peak_that_another_explanation_lacks_is_not_decidable() -> None:
    """A contact that another explanation finds too stiff for the simulation."""
    other = variant((), (), 0.05)
    stiff = other.model_copy(update={"theta": (0.05, *other.theta[1:3], 1e8)})
    s = situation(v=0.2, f=70.0)._replace(areas=(area(stiffness=1e9),))
    answer = Checker(of_diagnosis(gap_model(alternatives=(stiff,))))(s)
    assert answer.verdict == "not decidable" and "explanations" in answer.reasons[0]


@pytest.mark.parametrize(
    "std, v, f_p",
    [
        ({"m": 0.02, "d": 0.2, "k_f": 0.2, "k_c": 0.05, "v_e": 0.005, "f_p": 0.01}, 0.2, 60.0),
        ({"v_e": 0.5}, 0.05, 100.0),  # the force grows faster than the velocity
        ({"d": 0.5}, 0.2, 60.0),
        ({"m": 0.2, "k_c": 0.2, "v_e": 0.2, "f_p": 0.2}, 0.4, 20.0),  # much like a product
    ],
)
def test_confidence_holds_over_large_uncertainty(std: dict[str, float], v: float, f_p: float) -> None:
    checker = Checker(of_rig(RIG, std))
    found = exceeded(checker, situation("Palm (dominant side)", "quasi_static", v, f_p), 50_000)
    assert 0.01 < found < 0.0271, "three standard errors above 0.025"
    is_large = max(std.values()) > 0.3
    assert any("uncertain by more than 30%" in caution for caution in checker.cautions) == is_large


def test_a_peak_that_the_uncertainty_takes_away_is_not_decidable() -> None:
    rig = RIG | {"d": 300.0}
    s = situation("Palm (dominant side)", "quasi_static", 1.0, 10.0)
    assert Checker(of_rig(rig, {}))(s).upper is not None
    answer = Checker(of_rig(rig, {"d": 0.5, "k_f": 0.5}))(s)
    assert answer.verdict == "not decidable" and "leave open" in answer.reasons[0]


Ask = Callable[[str], str]


@pytest.fixture
def ask(tmp_path: Path) -> Ask:
    """The faults of a table of situations."""

    def told(text: str) -> str:
        (tmp_path / "situations.csv").write_text(text)
        with pytest.raises(InputError) as caught:
            read_situations(tmp_path / "situations.csv", LIMITS)
        return "\n".join(caught.value.faults)

    return told


NEEDED = "situation,body_area,contact,contact_velocity_m_per_s,pretension_n"


def test_a_misspelt_column_is_a_fault_and_a_note_is_none(ask: Ask, tmp_path: Path) -> None:
    for column, meant in (("contact_area_mm2", "contact_area_cm2"), ("Contact_Area", "contact_area_cm2"),
                          ("robot_mass", "robot_mass_kg"), ("payload", "payload_kg")):  # fmt: skip
        assert f"did you mean '{meant}'" in ask(f"{NEEDED},{column}\na,palm,transient,0.2,60,20\n")
    (tmp_path / "noted.csv").write_text(f"\n{NEEDED},note\n\na,palm,transient,0.2,60,x\n")
    (found,) = read_situations(tmp_path / "noted.csv", LIMITS)
    assert len(found.areas) == 2 and found.row == 4


def test_rows_in_another_unit_and_half_given_are_faults(ask: Ask) -> None:
    text = f"{NEEDED},contact_area_cm2,robot_mass_kg\n,palm,transient,200,0.06,200,20\n"
    for part in ("situation is empty", "mm/s, divide by 1000", "kN, multiply by 1000", "mm^2, divide by 100",
                 "belong together"):  # fmt: skip
        assert part in ask(text)
