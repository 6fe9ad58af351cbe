"""Proposals of the search: what each law promises, and what is fitted."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from acf_jax.diagnosis import proposals
from acf_jax.inference.baseline import Ground
from acf_jax.inference.fit import Fit, fit
from acf_jax.inference.forward import Grid
from acf_jax.inference.observations import Observations
from acf_jax.inference.parameters import begin
from tests.imagined import RIG, imagined

STOP = (0.8, 0.4)
WEIGHT = -1.0


@pytest.mark.parametrize("program", [None, ("end_stop", "gravity", "sensor_lag")])
def test_a_law_is_dropped_within_the_program_that_has_it(
    monkeypatch: pytest.MonkeyPatch, program: Any
) -> None:
    seen: list[tuple[Any, ...]] = []
    monkeypatch.setattr(
        proposals, "fit", lambda o, explanation, theta, *rest, **how: seen.append((explanation, theta, how))
    )
    monkeypatch.setattr(proposals, "with_sought", lambda fitted: fitted)
    both = ("end_stop", "gravity")
    physical = np.array([1.0, 2.0, 3.0, 4.0, 0.1, 0.2, 9.0])  # rig, end stop, gravity
    fitted: Any = SimpleNamespace(
        explanation=both,
        physical=physical,
        common=np.array([0.5, 0.6]),
        nuisance=None,
        program=Fit.program.fget(SimpleNamespace(explanation=both, grid=Grid(1e-4, 100, program=program))),  # type: ignore[attr-defined]
    )
    proposals.without(None, fitted, ("gravity",))  # type: ignore[arg-type]
    ((explanation, theta, how),) = seen
    assert explanation == ("gravity",) and how["program"] == (program or both)
    assert theta.tolist() == [1.0, 2.0, 3.0, 4.0, 9.0, 0.5, 0.6]


def test_a_second_mode_is_sought_where_a_law_is_dropped() -> None:
    """Another law may have stood in for it."""
    observations = imagined("sensor_resonance", (0.7, 0.2, 500.0, 1.6, 0.03, 0.02))
    theta = begin(RIG.values, [5.0], [0.7, 0.0, 500.0, 2.0, 0.03, 0.02])
    fitted = fit(observations, ("gravity", "sensor_resonance"), theta, warm=True, iterations=0)
    found = proposals.without(observations, fitted, ("sensor_resonance",))
    share, share_2, _, ratio, *_ = found.physical[-6:]
    assert [share, share_2, ratio] == pytest.approx([0.7, 0.2, 1.6], rel=0.02)


@pytest.fixture
def replaced(monkeypatch: pytest.MonkeyPatch) -> Any:
    """Runs `swap` with made-up promises of laws in place of each; returns what would be fitted."""

    def run(known: dict[tuple[str, ...], float]) -> list[Any]:
        gains = {
            "end_stop": {"coulomb_friction": 70.0, "sensor_lag": 30.0, "sensor_scale": 60.0},
            "gravity": {"pad_mass": 5.0},
            "robot_compliance": {"pad_mass": 3.0},
        }

        def couples(ground: Any, effects: Any) -> list[proposals.Couple]:
            promised = gains[ground.instead_of].items()
            return [proposals.Couple(ground, name, [], gain, 40.0 - gain / 2) for name, gain in promised]

        monkeypatch.setattr(proposals, "couples", couples)
        fitted = SimpleNamespace(explanation=tuple(sorted(gains)))
        ground: Any = SimpleNamespace(
            fitted=fitted, without=lambda law: SimpleNamespace(fitted=fitted, instead_of=law)
        )
        return [(couple.explanation, couple.objective) for couple in proposals.swap(ground, [], known)]

    return run


def test_another_law_is_put_in_place_of_each(replaced: Any) -> None:
    """Also where in place of another one two promise more; not what is known already."""
    assert replaced({("coulomb_friction", "gravity", "robot_compliance"): -900.0}) == [
        (("gravity", "robot_compliance", "sensor_scale"), 10.0),
        (("end_stop", "pad_mass", "robot_compliance"), 37.5),
        (("end_stop", "gravity", "pad_mass"), 38.5),
    ]


@pytest.mark.parametrize("behind, is_needed", [(30.0, False), (50.0, True)])
def test_a_law_stays_that_was_needed_beside_fewer(replaced: Any, behind: float, is_needed: bool) -> None:
    fewer, instead = ("end_stop", "gravity"), ("coulomb_friction", "gravity")
    found = replaced({fewer: -500.0, instead: -500.0 - behind, ("end_stop", "sensor_lag"): -500.0})
    kept = [explanation for explanation, _ in found if "end_stop" in explanation]
    assert len(found) - len(kept) == (not is_needed)


def end_stop_and_more(name: str, *strengths: float) -> Observations:
    """Trials of a rig with an end stop and another law, with exact forms."""
    laws = tuple(sorted(("end_stop", name)))
    values = {"end_stop": STOP, name: strengths}
    return imagined(laws, tuple(v for law in laws for v in values[law]))


def test_a_law_promises_what_it_does_beside_the_laws_that_are_there() -> None:
    """A weight changes the force otherwise where the flange stays at its stop at first."""
    o = end_stop_and_more("gravity", WEIGHT)
    stopped = fit(o, ("end_stop",), begin(RIG.values, STOP), warm=True)
    promised = {c.name: c.gain for c in proposals.couples(Ground.of(o, stopped), ["gravity"])}
    both = fit(o, ("end_stop", "gravity"), begin(RIG.values, STOP, [WEIGHT]), warm=True)
    assert promised["gravity"] == pytest.approx(2 * (stopped.objective - both.objective), rel=0.2)


def test_a_law_taken_out_leaves_most_of_it_to_its_imitator() -> None:
    o = end_stop_and_more("gravity", WEIGHT)
    both = fit(o, ("end_stop", "gravity"), begin(RIG.values, STOP, [WEIGHT]), warm=True)
    ground = Ground.of(o, both).without("gravity")
    best, other = sorted(
        proposals.couples(ground, ["coulomb_friction", "sensor_lag"]), key=lambda c: c.objective
    )
    assert best.explanation == ("coulomb_friction", "end_stop")
    assert best.objective < other.objective < ground.projector.left
    assert ground.projector.left > both.objective
