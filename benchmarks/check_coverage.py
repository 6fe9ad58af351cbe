"""How often a drawn force exceeds what a check says is not exceeded, over random rigs.

python -m benchmarks.check_coverage
"""

import argparse
from collections.abc import Sequence

import jax
import numpy as np

from acf_jax.contact.model import draw_forces
from acf_jax.contact.read import of_rig
from acf_jax.safety.check import Checker
from acf_jax.safety.limits import body_of, read_limits
from acf_jax.safety.situation import Situation
from benchmarks.machine import describe

DEVIATIONS = ((0.0, 0.05), (0.05, 0.2), (0.05, 0.3))  # relative, of each parameter, drawn between
CONFIDENCE, DRAWS = 0.975, 50_000


def draw_rig(random: np.random.Generator) -> tuple[dict[str, float], float, float]:
    """A rig, a velocity and a pretension of the wide box, damped below critical."""
    m, k_c, v = np.exp(random.uniform(np.log([0.5, 1e4, 0.01]), np.log([10.0, 1e6, 1.0]))).tolist()
    k_f, zeta, f_p = random.uniform(0.0, [1e4, 1.0, 500.0]).tolist()
    return {"m": m, "d": 2 * zeta * (m * (k_f + k_c)) ** 0.5, "k_f": k_f, "k_c": k_c}, v, f_p


def exceeded(random: np.random.Generator, low: float, high: float) -> float:
    """The share for one rig; NaN where the check does not tell a force."""
    rig, v, f_p = draw_rig(random)
    std = {name: float(random.uniform(low, high)) for name in (*rig, "v_e", "f_p")}
    checker = Checker(of_rig(rig, std), confidence=CONFIDENCE)
    situation = Situation("", read_limits().find("Sternum"), "quasi_static", v, f_p)
    upper = checker(situation).upper
    if upper is None or not np.isfinite(upper):
        return float("nan")
    body = body_of(situation.areas[0], situation.contact)
    found, exists = draw_forces(checker.model, checker.model.at(v, f_p), body, DRAWS, 1)
    return float(((found > upper) | ~exists).mean())


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.check_coverage", description=__doc__.splitlines()[0]
    )
    parser.add_argument("--rigs", type=int, default=60, help="of each kind (default: 60)")
    options = parser.parse_args(arguments)
    jax.config.update("jax_enable_x64", True)
    print(f"Confidence {CONFIDENCE}, so {1 - CONFIDENCE:.1%} asked; {DRAWS:,} draws a rig; {describe()}\n")
    print("| deviations of the parameters | rigs answered | above on average | above at worst |")
    print("|---|--:|--:|--:|")
    for low, high in DEVIATIONS:
        random = np.random.default_rng(0)
        shares = np.array([exceeded(random, low, high) for _ in range(options.rigs)])
        told = shares[np.isfinite(shares)]
        print(f"| {low:.0%} to {high:.0%} | {told.size} | {told.mean():.2%} | {told.max():.2%} |", flush=True)


if __name__ == "__main__":
    main()
