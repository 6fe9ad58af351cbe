"""Verdicts: what is allowed, what is not, and what cannot be decided."""

import jax
import pytest

from acf_jax.contact.model import ContactModel
from acf_jax.contact.read import of_diagnosis, of_rig
from acf_jax.safety.check import Checker, assumptions, body_of, limits_of
from acf_jax.safety.limits import read_limits
from acf_jax.safety.situation import Situation
from acf_jax.surrogate import load_surrogate
from tests.corrected import gap_model

RIG = {"m": 1.9, "d": 60.0, "k_f": 800.0, "k_c": 6e4}
STD = {"m": 0.02, "k_c": 0.05, "v_e": 0.005, "f_p": 0.01}
LIMITS = read_limits()


@pytest.fixture(scope="module")
def checker() -> Checker:
    return Checker(of_rig(RIG, STD), load_surrogate())


def situation(
    name: str = "Deltoid muscle", contact: str = "transient", v: float = 0.2, f: float = 60.0, **more: float
) -> Situation:
    return Situation("", LIMITS.find(name), contact, v, f, **more)  # type: ignore[arg-type]


def test_verdicts_on_either_side_of_the_limit_and_between(checker: Checker) -> None:
    s = situation(contact="quasi_static")
    top = checker.highest_speed(s)
    assert top is not None and checker(s._replace(v_e=top)).verdict == "allowed"
    above = checker(s._replace(v_e=top * 1.001))
    assert above.verdict == "not decidable" and "confidence" in above.reasons[0]
    assert above.force is not None and above.force < 150 < (above.upper or 0.0)
    over = checker(s._replace(v_e=2 * top))
    assert over.verdict == "not allowed" and over.force is not None and over.force > 150


def test_factor_belongs_to_the_limit_and_not_to_the_force(checker: Checker) -> None:
    clamped, free = situation(contact="quasi_static"), situation()
    assert limits_of(clamped) == (150, 190) and limits_of(free) == (300, 380)
    assert body_of(clamped).mobility == 0 and body_of(free).mobility == pytest.approx(1 / 3)
    a, b = checker(clamped), checker(free)
    assert a.force is not None and b.force is not None and b.force < a.force


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
    tried = Checker(of_rig(RIG, STD, None, ((0.05, 0.3), (50.0, 90.0))))
    assert tried(situation(v=0.2)).verdict == "allowed"
    for s in (situation(v=0.31), situation(v=0.01), situation(f=91.0)):
        answer = tried(s)
        assert answer.verdict == "not decidable" and "extrapolation" in answer.reasons[0]
    assert tried.highest_speed(situation("Kneecap")) == 0.3


def test_a_force_without_a_first_peak_is_not_decidable() -> None:
    stuck = Checker(of_rig({"m": 4.0, "d": 1200.0, "k_f": 9000.0, "k_c": 2e4}, {}), load_surrogate())
    answer = stuck(situation(v=0.8, f=10.0))
    assert answer.verdict == "not decidable" and answer.force is None


def test_surrogate_and_exact_model_agree_and_the_exact_one_decides_near_the_limit(checker: Checker) -> None:
    exact = Checker(checker.model)
    deciders = set()
    for v in (0.05, 0.2, 0.4, 0.8, 1.6):
        for name in ("Deltoid muscle", "Sternum", "Kneecap"):
            s = situation(name, "quasi_static", v=v)
            a, b = checker(s), exact(s)
            assert a.verdict == b.verdict and a.upper == pytest.approx(b.upper, rel=1e-4)
            assert (a.upper or 0) >= (b.upper or 0) * (1 - 1e-4)
            deciders.add(a.decided_by)
    assert "surrogate" in deciders
    s = situation(contact="quasi_static")
    near = checker(s._replace(v_e=checker.highest_speed(s) or 0.0))
    assert near.decided_by == "exact model"


def test_further_situations_do_not_compile_again(checker: Checker) -> None:
    checker(situation())
    with jax.log_compiles(), pytest.MonkeyPatch.context() as patch:
        patch.setattr("jax._src.compiler.compile_or_get_cached", None)  # compiling would fail
        for v in (0.11, 0.12):
            checker(situation("Kneecap", "quasi_static", v=v, f=70.0))


def corrected() -> ContactModel:
    return of_diagnosis(gap_model())


def test_corrected_model_checks_the_contact_force_not_the_sensors() -> None:
    model = corrected()
    answer = Checker(model, load_surrogate())(situation(v=0.2, f=70.0))
    assert answer.verdict == "allowed" and answer.decided_by == "simulation"
    assert Checker(model)(situation(v=0.5, f=70.0)).verdict == "not decidable"
    said = "\n".join(assumptions(model, situation(), 0.975))
    assert "no sensor's reading" in said and "30 N/mm act in series" in said
