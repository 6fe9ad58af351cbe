"""Every effect keeps every rule, alone and in pairs; a new file in the folder is tested with no new test code."""

import re
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest

from acf_jax import effects
from acf_jax.effects import library
from acf_jax.inference.parameters import every_effect
from tests.effects.contract import RULES, neutral, run, run_company, start
from tests.effects.forms import forces_of, recorded

ROOT = Path(__file__).parents[2]
SINGULAR = "with its frequency fixed a vanishing pad mass leaves a vanishing spring, not the paper's contact"


def cases():
    for name in library():
        for check in RULES:
            singular = (name, check.__name__) == ("pad_mass", "response_is_continuous_at_the_neutral_limit")
            marks = [pytest.mark.xfail(reason=SINGULAR, strict=True)] if singular else []
            yield pytest.param(name, check, id=f"{name}-{check.__name__}", marks=marks)


@pytest.mark.parametrize(("name", "check"), list(cases()))
def test_effect_keeps_the_rule(name, check):
    check(library()[name])


@pytest.mark.parametrize("name", recorded())
def test_a_law_that_changed_has_another_form(name):
    """Models that were fitted with the former law are refused by it; see `tests.effects.forms`."""
    known, kind = recorded()[name], every_effect()[name]
    assert known["form"] == kind.form, "record it: python -m tests.effects.forms"
    then, now = np.array(known["force_n"]), forces_of(kind, known["theta"])
    same = np.allclose(now, then, rtol=0, atol=1e-6 * np.abs(then).max())
    assert same, f"the law has changed: raise `form` in {name}.py, then python -m tests.effects.forms"


def test_the_library_has_the_effects_of_the_contract():
    assert set(library()) >= {
        *("coulomb_friction", "gravity", "force_regulation", "end_stop", "pretension_error"),
        *("contact_hardening", "contact_damping", "pad_relaxation", "pad_mass", "pad_bottoming"),
        *("robot_compliance", "robot_deceleration"),
        *("sensor_lag", "sensor_resonance", "sensor_scale", "fixture_mass"),
    }


def test_the_documentation_has_a_row_for_every_effect():
    rows = re.findall(r"^\| `(\w+)` \|(.*)$", (ROOT / "docs" / "effects.md").read_text(), re.M)
    named = {name: set(re.findall(r"`(\w+)`", row)) for name, row in rows}
    assert named == {name: {p.name for p in kind.parameters()} for name, kind in library().items()}


def test_the_documented_example_prints_what_the_page_shows(capsys):
    text = (ROOT / "docs" / "effects.md").read_text()
    code, shown = re.search(r"```python\n(.*?)```\n\n```text\n(.*?)```", text, re.S).groups()
    exec(code, {})
    assert capsys.readouterr().out == shown


def _rows(kinds, present):
    return [np.concatenate([start(k, -1) if k in who else neutral(k) for k in kinds]) for who in present]


FEW = ("coulomb_friction", "pad_mass", "robot_compliance", "sensor_lag")  # one of each component


@pytest.mark.parametrize("names", [FEW, pytest.param(tuple(library()), marks=pytest.mark.long)], ids=len)
def test_effects_compose_in_any_order(names):
    """One program that holds all of them: the absent ones are neutral, so it must also equal each effect alone."""
    kinds = tuple(library()[name] for name in names)
    present = [*combinations(kinds, 1), *combinations(kinds, 2)]
    there = run_company(kinds, _rows(kinds, present))
    back = run_company(kinds[::-1], _rows(kinds[::-1], present))
    for who, *forces in zip(present, *there, *back, strict=True):
        sensed, contact, sensed_back, contact_back = forces
        names = [kind.id() for kind in who]
        assert np.isfinite(forces).all(), names
        assert np.allclose(contact, contact_back, rtol=0, atol=1e-8), names
        # two sensors in series are linear in F up to what a sample holds between its grid points
        assert np.allclose(sensed, sensed_back, rtol=0, atol=2e-2), names
        if len(who) == 1:
            alone = run(who[0], [start(who[0], -1)])
            assert np.allclose(sensed, alone.sensed[0], rtol=0, atol=1e-8), names


@pytest.fixture
def example(tmp_path, monkeypatch):
    """The effect that CONTRIBUTING.md shows, written to a folder of its own that the library also searches."""
    text = (ROOT / "CONTRIBUTING.md").read_text()
    name, code = re.search(r"`src/acf_jax/effects/(\w+)\.py`:\n\n```python\n(.*?)```", text, re.S).groups()
    (tmp_path / f"{name}.py").write_text(code)
    monkeypatch.setattr(effects, "__path__", [*effects.__path__, str(tmp_path)])
    library.cache_clear()
    yield name
    library.cache_clear()


def test_a_new_effect_is_one_new_file(example):
    kind = library()[example]
    for check in RULES:
        check(kind)


def test_a_reading_away_from_the_sensor_is_refused(example):
    """The simulator would not ask for it."""
    rules = {check.__name__: check for check in RULES}

    class Reads(library()[example]):
        def sense(self, f, h, memory):
            return memory, 2 * f[1]

    with pytest.raises(AssertionError):
        rules["it_acts_where_it_says"](Reads)


def test_the_rules_can_fail(example):
    """A bad effect is caught: one that is not neutral, adds energy and hides its source."""

    class Bad(library()[example]):
        title = ""

        def force_on_mass(self, motion, state):
            return 1.0 + 20.0 * motion.x_dot

    broken = []
    for check in RULES:
        try:
            check(Bad)
        except AssertionError:
            broken.append(check.__name__)
    assert set(broken) >= {"neutral_limit_is_the_papers_model", "it_supplies_no_energy", "it_is_described"}
