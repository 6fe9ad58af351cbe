"""Files of surrogates whose checksum is right, and whose content no training gives."""

import json
from collections.abc import Callable
from operator import attrgetter
from pathlib import Path
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from acf_jax.contact.body import Body
from acf_jax.contact.model_file import ModelFile
from acf_jax.errors import InputError
from acf_jax.surrogate import load_corrected, load_surrogate
from acf_jax.surrogate.load import DEFAULT, with_dtype
from acf_jax.surrogate.saved import signed, write_tree

CORRECTED = Path(__file__).parents[2] / "examples/rig_surrogate.eqx"


def resigned(path: Path, source: Path, change: Callable[[dict[str, Any]], None], tree: Any = None) -> Path:
    """A file with another header, and if wanted other leaves, under a checksum that is right."""
    line, _, body = source.read_bytes().partition(b"\n")
    header = json.loads(line)
    change(header)
    if tree is None:
        path.write_bytes(signed(header, body))
    else:
        write_tree(path, header, tree)
    return path


def test_the_example_keeps_its_bound_to_the_law_as_it_is_now() -> None:
    """A law that changes has to be learnt anew; 512 samples of the range, and as many at its edges."""
    model, surrogate = ModelFile(CORRECTED).load_exact()
    assert surrogate is not None
    unit = np.random.default_rng(0).random((1024, len(surrogate.domain.free)))
    unit[512:] = np.round(unit[512:])
    q = jnp.asarray(surrogate.domain.at(unit))
    exact = jax.jit(jax.vmap(lambda z: model.main.peak(z[:-1], Body(0.0, z[-1])).force))(q)
    assert float(jnp.abs(surrogate(q.T)[0] / exact - 1).max()) < float(surrogate.bounds.force)


@pytest.mark.parametrize(
    ("name", "change", "fault"),
    [
        ("m", {"low": -1.0}, "ranges.m: low must be above 0, but is -1; train it again"),
        ("m", {"low": 0.0}, "ranges.m: low must be above 0, but is 0; train it again"),
        ("m", {"low": 10.0, "high": 0.5}, r"ranges.m: low \(10\) is above high \(0.5\); train it again"),
        ("f_p", {"low": -5, "high": 500}, "ranges.f_p: low must be 0 or above, but is -5; train it again"),
        ("f_p", {"low": True}, "ranges.f_p.low: must be a number, but is True; train it again"),
        ("k_c", {"high": None}, "ranges.k_c.high: must be a number, but is empty"),
        ("v_e", {"unit": "mm/s"}, "ranges.v_e: must be in m/s; train it again"),
        ("v_e", {"low": -1, "high": -2}, r"ranges.v_e: low \(-1\) is above high \(-2\)"),
    ],
)  # fmt: skip
def test_ranges_that_no_rig_has_are_refused_under_a_right_checksum(tmp_path, name, change, fault) -> None:
    path = resigned(tmp_path / "a.eqx", DEFAULT, lambda header: header["ranges"][name].update(change))
    with pytest.raises(InputError, match=r"a\.eqx: header: " + fault):
        load_surrogate(path)


@pytest.mark.parametrize(
    ("place", "value", "fault"),
    [
        ("held_out.largest", -1.0, "its error bound is negative, or shrinks towards the fold"),
        (
            "held_out.largest",
            np.linspace(0, 1, 10),
            "its error bound is negative, or shrinks towards the fold",
        ),
        ("held_out.edges", np.linspace(1, 0.1, 10), "do not lead from 0 to 1"),
        ("held_out.edges", np.linspace(0.05, 0.5, 10), "do not lead from 0 to 1"),
        ("x.scale", 0.0, "scales that are not above 0"),
        ("y.scale", -1.0, "scales that are not above 0"),
        ("y.centre", np.nan, "numbers that are not finite"),
    ],
)
def test_numbers_that_no_training_gives_are_refused_under_a_right_checksum(
    tmp_path: Path, place: str, value: Any, fault: str
) -> None:
    where, shipped = attrgetter(place), load_surrogate()
    wrong = eqx.tree_at(where, shipped, jnp.broadcast_to(jnp.asarray(value, float), where(shipped).shape))
    path = resigned(tmp_path / "a.eqx", DEFAULT, lambda header: None, with_dtype(wrong, "float32"))
    with pytest.raises(InputError, match=rf"a\.eqx: .*{fault}; train it again"):
        load_surrogate(path)


@pytest.mark.parametrize(
    ("index", "low", "high", "fault"),
    [
        (0, -2.0, 1.7, "ranges.m: low must be above 0, but is -2"),
        (1, 90.0, 40.0, r"ranges.d: low \(90\) is above high \(40\)"),
        (8, -1.0, 0.0, "ranges.mobility: low must be 0 or above, but is -1"),
        (4, -1.0, 0.5, "domain: end_stop.share leaves what it can be, 0 to "),
    ],
)
def test_ranges_of_a_corrected_model_that_no_rig_has(tmp_path, index, low, high, fault) -> None:
    def change(header: dict[str, Any]) -> None:
        header["domain"]["low"][index], header["domain"]["high"][index] = low, high

    path = resigned(tmp_path / "a.eqx", CORRECTED, change)
    with pytest.raises(InputError, match=rf"a\.eqx: header: {fault}.*; train it again"):
        ModelFile(path).load()


@pytest.mark.parametrize(
    ("key", "value", "fault"),
    [
        ("logarithmic", [True] * 9, "domain: a logarithmic range begins at 0 or below"),
        ("logarithmic", [1] * 9, "must be true or false, but is 1"),
        ("names", ["m"] * 9, "domain: its columns do not fit each other"),
        ("low", [1.0], "domain: its columns do not fit each other"),
    ],
)
def test_a_domain_of_a_corrected_model_that_is_none(tmp_path, key, value, fault) -> None:
    path = resigned(tmp_path / "a.eqx", CORRECTED, lambda header: header["domain"].update({key: value}))
    with pytest.raises(InputError, match=rf"a\.eqx: header: .*{fault}"):
        ModelFile(path).load()


@pytest.mark.parametrize("name", ["force", "time", "least"])
def test_a_negative_bound_of_a_corrected_model_is_refused(tmp_path: Path, name: str) -> None:
    surrogate, _ = load_corrected(CORRECTED)
    wrong = eqx.tree_at(lambda s: getattr(s.bounds, name), surrogate, jnp.asarray(-1e-3))
    path = resigned(tmp_path / "a.eqx", CORRECTED, lambda header: None, with_dtype(wrong, "float32"))
    with pytest.raises(InputError, match=r"a\.eqx: a bound of its error is negative; train it again"):
        ModelFile(path).load()


def test_a_corrected_model_of_another_effect_is_refused(tmp_path: Path) -> None:
    def change(header: dict[str, Any]) -> None:
        header["domain"]["names"][4] = "end_stop.other"

    path = resigned(tmp_path / "a.eqx", CORRECTED, change)
    with pytest.raises(InputError, match="stands for another model than it carries; train it again"):
        ModelFile(path).load()


def test_columns_get_the_answers_of_single_samples():
    """One box's face, its middle and what lies outside, in columns and one by one."""
    surrogate, _ = load_corrected(CORRECTED)
    domain = surrogate.domain
    unit = np.random.default_rng(2).random((40, len(domain.free)))
    unit[0], unit[1] = 0.0, 1.0
    q = domain.at(unit)
    q[2, 0] *= 3
    together = surrogate.predict(jnp.asarray(q.T))
    single = [surrogate.predict(jnp.asarray(sample)) for sample in q]
    for name in together._fields:
        one_by_one = np.array([getattr(found, name) for found in single])
        assert np.asarray(getattr(together, name)) == pytest.approx(one_by_one, rel=1e-13)
    assert not together.is_inside[2] and together.is_inside[3:].any()
