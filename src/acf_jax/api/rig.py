"""Rig, impact and prior as a user writes them: every number is looked at for its unit."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from jaxtyping import ArrayLike

from acf_jax import model
from acf_jax.api._values import begin, check, path_of, plain
from acf_jax.dataset import trials
from acf_jax.dataset.description import check_prior
from acf_jax.dataset.units import QUANTITIES
from acf_jax.errors import InputError, shown
from acf_jax.model import Peak
from acf_jax.recording.rig import RigFile, read_rig_file, stated

Numbers = ArrayLike | Sequence[float]
Known = Sequence[float] | trials.Prior  # a value and its standard deviation


class Rig(model.Rig):
    """An active contact flange on a robot: moving mass, damping, stiffness of the actuator and of the contact.

    The numbers are looked at once, here: `Rig(m=4000, ...)` asks whether grams were meant. Values that JAX traces, and
    copies that `jax.tree.map` or `jax.jit` make, are not looked at. A rig beyond these limits is an
    `acf_jax.model.Rig`, which asks for signs only.

    **Arguments:** `m`: kg, 0.02 to 100; `d`: N s/m, 0 to 1e5; `k_f`: N/m, 0 to 1e7; `k_c`: N/m, 2e3 to 1e9. Each a
    number or an array; arrays broadcast in `find_peaks`.

    **Raises:** `InputError`, a `ValueError`, that lists each number that cannot be right with the remedy.

    >>> import acf_jax as acf
    >>> acf.Rig(m=4.0, d=60.0, k_f=2000.0, k_c=175561.0)
    Rig(m=4 kg, d=60 N s/m, k_f=2000 N/m, k_c=175561 N/m)
    """

    def __init__(self, m: Numbers, d: Numbers, k_f: Numbers, k_c: Numbers):
        begin()
        check("Rig", m=m, d=d, k_f=k_f, k_c=k_c)
        given: tuple[Any, ...] = (m, d, k_f, k_c)
        super().__init__(*given)


class Impact(model.Impact):
    """How robot and part meet; the numbers are looked at as those of `Rig` are.

    **Arguments:** `v_e`: contact velocity, m/s, 0 or 1e-5 to 5; `f_p`: pretension F_P, N, 0 to 5000. Each a number or
    an array; arrays broadcast in `find_peaks`.

    **Raises:** `InputError`, a `ValueError`, that lists each number that cannot be right with the remedy.

    >>> import acf_jax as acf
    >>> acf.Impact(v_e=[0.1, 0.2, 0.3], f_p=100.0)
    Impact(v_e=0.1 to 0.3 m/s (3,), f_p=100 N)
    """

    def __init__(self, v_e: Numbers, f_p: Numbers):
        begin()
        check("Impact", v_e=v_e, f_p=f_p)
        given: tuple[Any, ...] = (v_e, f_p)
        super().__init__(*given)


class Prior(trials.RigPrior):
    """What is known of a rig before any trial: value and standard deviation of each parameter.

    Be honest about the deviations: one that is too small makes a diagnosis blame an effect for a wrong parameter.

    **Arguments:** `m`, kg; `d`, N s/m; `k_f`, N/m; `k_c`, N/m: each a pair (value, standard deviation).

    **Raises:** `InputError` that lists each value that cannot be right with the remedy.

    >>> import acf_jax as acf
    >>> acf.Prior(m=(1.75, 0.035), d=(72, 17), k_f=(3960, 1440), k_c=(1.12e5, 1.2e4))
    Prior(m=1.75 ± 0.035 kg, d=72 ± 17 N s/m, k_f=3960 ± 1440 N/m, k_c=112000 ± 12000 N/m)
    """

    def __init__(self, m: Known, d: Known, k_f: Known, k_c: Known):
        given = {"m": m, "d": d, "k_f": k_f, "k_c": k_c}
        faults = [fault for name, known in given.items() if (fault := _pair_fault(name, known))]
        if faults:
            raise InputError(faults)
        checked = check_prior({name: _pair(known) for name, known in given.items()}, "Prior")
        super().__init__(checked.m, checked.d, checked.k_f, checked.k_c)

    def __repr__(self) -> str:
        return f"Prior({prior_words(self)})"


def prior_words(prior: trials.RigPrior) -> str:
    """The four parameters with deviations and units, on one line."""
    known = {name: getattr(prior, name) for name in ("m", "d", "k_f", "k_c")}
    return ", ".join(f"{n}={p.value:.6g} ± {short(p.std)} {QUANTITIES[n].unit}" for n, p in known.items())


def short(value: float) -> str:
    """Three digits, written out."""
    return f"{float(f'{value:.3g}'):g}"


def prior_of(rig: trials.RigPrior | str | Path) -> trials.RigPrior:
    """The prior itself, or that in a rig's file."""
    return rig_file_of(rig).prior


def rig_file_of(rig: trials.RigPrior | str | Path) -> RigFile:
    """What a rig's file states, of the measurement, too; of a prior that alone."""
    if isinstance(rig, trials.RigPrior):
        prior = trials.RigPrior(rig.m, rig.d, rig.k_f, rig.k_c)  # as files give it, whatever class it has
        return stated(prior)
    if isinstance(rig, str | Path):
        return read_rig_file(path_of(rig))
    remedy = "give an acf_jax.Prior, or the path of a rig's file"
    raise InputError(f"rig: a diagnosis needs standard deviations, but is given {shown(rig)}; {remedy}")


def find_peak(rig: model.Rig, impact: model.Impact) -> Peak:
    """Peak contact force of one impact, by the paper's model.

    F_C,max = F_C(t_max),  dF_C/dt(t_max) = 0   (Eqs. 9 and 11)

    **Arguments:** `rig`, `impact`: one sample of numbers.

    **Returns:** `Peak`: `f_max` in N, `t_max` in s, and `has_peak`, all scalars. Differentiable twice with `jax.grad`
    and the like; maps with `jax.vmap`.

    **Raises:** `ValueError` for arrays.

    >>> import acf_jax as acf
    >>> rig = acf.Rig(m=4.0, d=60.0, k_f=2000.0, k_c=175561.0)
    >>> acf.find_peak(rig, acf.Impact(v_e=0.2, f_p=100.0))
    Peak(196.99 N after 5.067 ms)
    """
    _sample(rig, impact)
    return model.find_peak(rig, impact)


def find_peaks(rig: model.Rig, impact: model.Impact) -> Peak:
    """Peak contact forces of many impacts, by the paper's model; several times faster than one by one.

    **Arguments:** `rig`, `impact`: fields are numbers or arrays, which broadcast to one shape, such as (N,).

    **Returns:** `Peak`: `f_max` in N, `t_max` in s, and `has_peak`, arrays of that shape. Differentiable as
    `find_peak` is.

    **Raises:** `ValueError` for numbers alone, and for shapes that do not fit each other.

    >>> import acf_jax as acf, numpy as np
    >>> rig = acf.Rig(m=4.0, d=0.0, k_f=0.0, k_c=175561.0)
    >>> peaks = acf.find_peaks(rig, acf.Impact(v_e=np.linspace(0.05, 0.35, 4), f_p=100.0))
    >>> peaks
    Peak(108.42 to 309.88 N after 1.894 to 5.929 ms, 4 impacts)
    >>> print(peaks.f_max.round(1))
    [108.4 160.6 232.1 309.9]
    """
    _sample(rig, impact)
    return model.find_peaks(rig, impact)


def _sample(rig: Any, impact: Any) -> None:
    """JAX in float64, for a rig and an impact; `InputError` for what is neither."""
    begin()
    if not isinstance(rig, model.Rig) or not isinstance(impact, model.Impact):
        raise InputError(
            f"find_peak takes a Rig and an Impact, but is given {shown(rig)} and {shown(impact)}"
        )


def _pair(known: Known) -> tuple[Any, Any]:
    value, std = (known.value, known.std) if isinstance(known, trials.Prior) else known
    return plain(value), plain(std)


def _pair_fault(name: str, known: Any) -> str | None:
    try:
        value, std = _pair(known)
    except (TypeError, ValueError):
        what = f"must be a value and its standard deviation, but is {shown(known)}"
        return f"Prior.{name}: {what}; give a pair, as in {name}=({shown(plain(known))}, ...)"
    wrong = [x for x in (value, std) if not isinstance(x, int | float) or isinstance(x, bool)]
    return f"Prior.{name}: must hold two numbers, but holds {shown(wrong[0])}; correct it" if wrong else None
