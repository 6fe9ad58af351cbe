"""How long one answer takes in Python: exact peak, surrogate, certified bound, and the whole check.

python -m benchmarks.check_latency
"""

import statistics
import time
from collections.abc import Callable

import jax
import numpy as np

from acf_jax.contact.body import Body
from acf_jax.contact.read import of_rig
from acf_jax.model import Impact, Rig, find_peak
from acf_jax.safety.check import Checker
from acf_jax.safety.limits import read_limits
from acf_jax.safety.situation import Situation
from acf_jax.surrogate import load_surrogate

CALLS = 5000
RIG = {"m": 1.9, "d": 60.0, "k_f": 800.0, "k_c": 6e4}
STD = {"m": 0.02, "d": 0.2, "k_f": 0.3, "k_c": 0.05, "v_e": 0.005, "f_p": 0.01}


def microseconds(call: Callable[[float], object]) -> tuple[float, float]:
    """Median and 99th percentile of calls at different velocities, after the compiling ones."""
    speeds = np.random.default_rng(0).uniform(0.05, 0.5, CALLS).tolist()
    for v in speeds[:100]:
        call(v)
    spent = []
    for v in speeds:
        start = time.perf_counter_ns()
        call(v)
        spent.append((time.perf_counter_ns() - start) / 1e3)
    return statistics.median(spent), float(np.quantile(spent, 0.99))


def main() -> None:
    jax.config.update("jax_enable_x64", True)
    model, surrogate = of_rig(RIG, STD), load_surrogate()
    quick, exact = Checker(model, surrogate), Checker(model)
    asked = Situation("", read_limits().find("Sternum"), "quasi_static", 0.1, 60.0, contact_area=2.0)
    values = np.array([*RIG.values(), 0.0, 60.0])

    peak = jax.jit(lambda z: find_peak(Rig(*z[:4]), Impact(z[4], z[5])).f_max)
    network = jax.jit(lambda z: surrogate.force(Rig(*z[:4]), Impact(z[4], z[5])))

    def at(v: float) -> np.ndarray:
        z = values.copy()
        z[4] = v
        return z

    rows = {
        "exact peak": lambda v: float(peak(at(v))),
        "surrogate": lambda v: float(network(at(v))),
        "exact peak and its deviation": lambda v: exact.exact(at(v), Body(1e-5, 0.0)),
        "surrogate, proved bound, deviation": lambda v: quick.quick(at(v), Body(1e-5, 0.0)),  # type: ignore[misc]
        "check, by the surrogate where it decides": lambda v: quick(asked._replace(v_e=v)),
        "check, by the exact model": lambda v: exact(asked._replace(v_e=v)),
    }
    print(f"{'one call, microseconds':42} {'p50':>8} {'p99':>8}")
    for name, call in rows.items():
        p50, p99 = microseconds(call)
        print(f"{name:42} {p50:8.1f} {p99:8.1f}")


if __name__ == "__main__":
    main()
