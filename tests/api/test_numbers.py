"""Numbers of a user are looked at where they enter, and nowhere else."""

import copy
import pickle

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import acf_jax as acf
from acf_jax import model
from acf_jax.dataset import Prior as Known
from acf_jax.dataset import RigPrior
from acf_jax.errors import InputError

RIG = {"m": 4.0, "d": 60.0, "k_f": 2000.0, "k_c": 175561.0}


@pytest.mark.parametrize("change, says", [
    ({"m": 4000}, "Rig.m must be at most 100 kg, but is 4000; if it is in g, divide by 1000"),
    ({"k_c": 175.5}, "Rig.k_c must be at least 2000 N/m, but is 175.5; if it is in N/mm, multiply by 1000"),
    ({"m": np.array([4.0, 4000.0])}, "Rig.m must be at most 100 kg, but is 4000"),
    ({"m": [4.0, float("nan")]}, "Rig.m must be a number, finite and positive, in kg, but is nan"),
    ({"d": jnp.float32(-1)}, "Rig.d must be a number, finite and zero or positive, in N s/m, but is -1.0"),
    ({"m": "4"}, "Rig.m must be a number, finite and positive, in kg, but is '4'"),
    ({"m": True}, "Rig.m must be a number, finite and positive, in kg, but is True"),
    ({"m": None}, "Rig.m must be a number, finite and positive, in kg, but is None"),
    ({"m": 10**400}, "Rig.m must be a number"),
    ({"m": 0}, "Rig.m must be a number, finite and positive, in kg, but is 0"),
])  # fmt: skip
def test_a_number_in_another_unit_is_asked_about(change, says):
    with pytest.raises(InputError) as told:
        acf.Rig(**RIG | change)
    assert told.value.faults[0].startswith(says)


def test_all_faults_at_once():
    with pytest.raises(InputError) as told:
        acf.Rig(m=4000, d=-1, k_f=2000, k_c=1)
    assert [fault.split()[0] for fault in told.value.faults] == ["Rig.m", "Rig.d", "Rig.k_c"]
    with pytest.raises(InputError) as told:
        acf.Impact(v_e=200, f_p=float("inf"))
    assert "if it is in mm/s, divide by 1000" in told.value.faults[0] and len(told.value.faults) == 2


def test_what_transformations_make_is_not_looked_at():
    """Gradients are no rigs; copies and traced values pass; the class stays."""
    rig, impact = acf.Rig(**RIG), acf.Impact(0.2, 100.0)
    slope = jax.grad(lambda rig: acf.find_peak(rig, impact).f_max)(rig)
    assert type(slope) is acf.Rig and 0 < float(slope.k_c) < 1e-3  # no stiffness of a contact
    heavy = jax.tree.map(lambda x: 1e4 * x, rig)
    assert type(heavy) is acf.Rig and float(heavy.m) == 4e4
    assert float(jax.jit(lambda m: acf.Rig(m, 60.0, 2e3, 1.7e5).m)(4e3)) == 4e3
    swept = jax.vmap(lambda v: acf.find_peak(rig, acf.Impact(v, 100.0)).f_max)(jnp.array([0.1, 0.2]))
    assert float(swept[1]) == pytest.approx(float(acf.find_peak(rig, impact).f_max), rel=1e-12)
    assert repr(copy.deepcopy(rig)) == repr(pickle.loads(pickle.dumps(rig))) == repr(rig)
    assert isinstance(rig, model.Rig)
    assert model.Rig(m=4000, d=0, k_f=0, k_c=500).m == 4000  # the library's own asks for signs only


def test_numbers_broadcast_against_arrays():
    rig = acf.Rig(**RIG)
    swept = acf.find_peaks(rig, acf.Impact(v_e=np.linspace(0.05, 0.35, 7), f_p=100.0))
    assert swept.f_max.shape == (7,) and swept.f_max.dtype == jnp.float64
    alone = acf.find_peak(rig, acf.Impact(v_e=0.35, f_p=100.0))
    assert float(swept.f_max[-1]) == pytest.approx(float(alone.f_max), rel=1e-12)
    assert (
        acf.find_peaks(acf.Rig(**RIG | {"m": [3.0, 4.0]}), acf.Impact(0.35, 100.0)).f_max[1]
        == swept.f_max[-1]
    )


def test_a_prior_is_value_and_deviation_of_each():
    prior = acf.Prior(m=(2.1, 0.04), d=[60, 18], k_f=Known(800.0, 500.0), k_c=np.array([3.4e5, 4e4]))
    assert isinstance(prior, RigPrior) and prior.values.tolist() == [2.1, 60, 800, 3.4e5]
    assert repr(prior).startswith("Prior(m=2.1 ± 0.04 kg, d=60 ± 18 N s/m, ")
    for change, says in (
        (
            {"m": 2.1},
            "Prior.m: must be a value and its standard deviation, but is 2.1; give a pair, as in m=(2.1, ...)",
        ),
        (
            {"m": (2100, 40)},
            "Prior.m.value: must be at most 100 kg, but is 2100; if it is in g, divide by 1000",
        ),
        ({"d": (60, 0)}, "Prior.d.std: must be a number above 0"),
        ({"k_c": (3.4e5, "4e4")}, "Prior.k_c: must hold two numbers, but holds '4e4'"),
        ({"k_c": (3.4e5, float("nan"))}, "Prior.k_c.std: must be a finite number"),
        ({"m": (2.1, 0.04, 3)}, "Prior.m: must be a value and its standard deviation"),
    ):
        given = {"m": (2.1, 0.04), "d": (60, 18), "k_f": (800, 500), "k_c": (3.4e5, 4e4)} | change
        with pytest.raises(InputError) as told:
            acf.Prior(**given)
        assert told.value.faults[0].startswith(says)
