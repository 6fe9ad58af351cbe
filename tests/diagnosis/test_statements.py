"""What is said of scatter that hides causes, and what to do about it."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import pytest

from acf_jax.dataset import LowPass, Noise
from acf_jax.diagnosis.statements import of_minor, of_scatter
from acf_jax.evidence.posterior import UNKNOWN, Posterior, Scored
from acf_jax.inference.parameters import Explanation
from acf_jax.inference.ring import Ring
from tests.repeated import repeated

QUIET = 0.1  # N, before contact


@pytest.mark.parametrize(("frequencies", "low_pass", "advised"), [
    ((500.0, 900.0), None, True),
    ((20.0,), None, False),  # as slow as the contact: a filter would take the impact, too
    ((), None, False),
    ((500.0,), LowPass(250.0), False),  # it is applied already
])  # fmt: skip
def test_a_fast_ring_that_hides_causes_is_to_be_filtered(
    frequencies: tuple[float, ...], low_pass: LowPass | None, advised: bool
) -> None:
    rings = tuple(Ring(f, 0.02, 10.0, 100.0, 1) for f in frequencies)
    noisy = Noise(5.0, source="repeats")
    o = replace(repeated(0.0), noise=noisy, rings=rings, low_pass=low_pass)
    (said,) = of_scatter(QUIET, o)
    assert "differ by 5 N a sample, 50 times the noise before contact" in said
    assert ("--low-pass 250" in said) is advised


def test_nothing_is_said_of_repeats_that_agree() -> None:
    assert not of_scatter(QUIET, replace(repeated(0.0), noise=Noise(QUIET)))
    assert not of_scatter(0.0, replace(repeated(0.0), noise=Noise(QUIET)))  # as exact as a simulation is


def test_small_laws_are_said_with_what_may_stand_in_their_place() -> None:
    """Nothing is said where the cause is unknown."""
    of = {
        ("contact_damping", "fixture_mass"): 0.6,
        ("fixture_mass", "gravity"): 0.38,
        ("fixture_mass",): 0.02,
    }
    corrected: Any = SimpleNamespace(explanation=("contact_damping", "fixture_mass"))

    def told(first: Explanation) -> Posterior:
        return Posterior((Scored(first, 0.9),), {first: of}, {first: {0.0: 1.0}})

    assert not of_minor(corrected, told(UNKNOWN))
    (said,) = of_minor(corrected, told(("fixture_mass",)))
    assert "also has contact damping: too small" in said
    assert said.endswith("contact damping 60 %, constant force on the flange (gravity) 38 %")
