"""The speed comparison compares right answers: each peer against mpmath on samples of the wide box."""

import numpy as np
import pytest

from benchmarks import write_docs
from benchmarks.box import draw_box, take
from benchmarks.peers import mpmath_peak
from benchmarks.peers.bracket import bracket
from benchmarks.timing import interleave, median_ratio
from tests.needs import need_module

BOX = draw_box(60, seed=3)
ENDS = bracket(BOX)


@pytest.fixture(scope="module")
def truth():
    return mpmath_peak.peaks(BOX, ENDS.chosen)


def answers(peer):
    """The peer's answers for the samples that have a peak."""
    found = dict(zip(peer.chosen.tolist(), peer.answers(peer.call()).T, strict=True))
    return np.array([found[i] for i in ENDS.chosen.tolist()]).T


def test_box_has_both_kinds_of_samples():
    assert 0 < len(ENDS.chosen) < len(BOX.m)
    assert np.all((ENDS.lower <= ENDS.guess) & (ENDS.guess <= ENDS.upper))


@pytest.mark.parametrize("variant", [0, *(pytest.param(i, marks=pytest.mark.long) for i in (1, 2))])
def test_numba(variant, truth):
    need_module("numba", "pip install numba")
    from benchmarks.peers import numba_peak

    peer = numba_peak.peers(BOX)[variant]
    np.testing.assert_allclose(answers(peer)[0], truth[0], rtol=2e-15)
    np.testing.assert_allclose(answers(peer)[1], truth[1], rtol=1e-9)
    assert peer.call()[2].nonzero()[0].tolist() == sorted(ENDS.chosen.tolist())


@pytest.mark.parametrize("name", ["elementwise_find_root", "brentq_loop"])
def test_scipy(name, truth):
    from benchmarks.peers import scipy_peak

    peer = getattr(scipy_peak, name)(BOX, ENDS, 1e-12)
    np.testing.assert_allclose(answers(peer)[0], truth[0], rtol=1e-13)
    np.testing.assert_allclose(answers(peer)[1], truth[1], rtol=1e-9)


def test_jax(truth):
    from benchmarks.peers import jax_peak

    np.testing.assert_allclose(answers(jax_peak.exact(BOX)), truth, rtol=1e-13)
    few = take(BOX, slice(20))
    newton = jax_peak.optimistix_newton(few, 1e-12)
    exact = jax_peak.exact(few)
    with_peak = bracket(few).chosen
    own, other = (p.answers(p.call())[:, with_peak] for p in (newton, exact))
    np.testing.assert_allclose(own, other, rtol=1e-11)


def test_rounds_are_interleaved():
    order: list[str] = []
    seconds = interleave({name: lambda name=name: order.append(name) for name in "ab"}, repeats=2, rest=0.0)
    assert order == ["a", "b"] * 3 and len(seconds["a"]) == 2
    assert median_ratio([2.0, 6.0, 4.0], [1.0, 2.0, 2.0]) == 2.0


@pytest.mark.parametrize("output, shown", [("42", "```text\n42\n```"), ("|--:|", "|--:|")])
def test_documentation_gets_the_output_of_its_commands(output, shown):
    block = f"before\n<!-- run: python -c 'print(\"{output}\")' -->\n%s<!-- end -->\nafter"
    assert write_docs.rewrite(block % "old\n") == block % f"\n{shown}\n\n"
    assert write_docs.rewrite(block % "old\n", only="nothing like it") == block % "old\n"
