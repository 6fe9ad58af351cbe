"""How often a drawn force exceeds what a check says is not exceeded, or has no peak, over rigs of the wide box.

python -m benchmarks.check_coverage
"""

import argparse
from collections.abc import Sequence

import jax
import numpy as np

from acf_jax.contact.model import draw_forces
from acf_jax.contact.peak import RIG
from acf_jax.contact.read import of_rig
from acf_jax.safety.check import Checker
from acf_jax.safety.limits import body_of, read_limits
from acf_jax.safety.situation import Situation
from benchmarks.box import Box, draw_box
from benchmarks.machine import describe

DEVIATIONS = ((0.0, 0.05), (0.05, 0.2), (0.05, 0.3))  # relative, of each parameter, drawn between
CONFIDENCE, DRAWS = 0.975, 50_000


def exceeded(z: Sequence[float], std: dict[str, float]) -> tuple[float, float]:
    """Both shares for one rig and impact; NaN where the check answers that the model may have no peak."""
    *rig, v, f_p = z
    checker = Checker(of_rig(dict(zip(RIG, rig, strict=True)), std), confidence=CONFIDENCE)
    situation = Situation("", read_limits().find("Sternum"), "quasi_static", v, f_p)
    body = body_of(situation.areas[0], situation.contact)
    (answer,) = checker.exact(np.array([*checker.theta, v, f_p, *body, *situation.ending]))
    if not (answer.exists and answer.is_known):
        return np.nan, np.nan
    found, exists = draw_forces(checker.model, checker.model.at(v, f_p), body, DRAWS, 1)
    return float((exists & (found > answer.upper)).mean()), float((~exists).mean())


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.check_coverage", description=__doc__.splitlines()[0]
    )
    parser.add_argument("--rigs", type=int, default=60, help="of each kind (default: 60)")
    options = parser.parse_args(arguments)
    jax.config.update("jax_enable_x64", True)
    print(f"Confidence {CONFIDENCE}, so {1 - CONFIDENCE:.1%} asked; {DRAWS:,} draws a rig; {describe()}\n")
    print(
        "| deviations of the parameters | rigs answered | above on average | at worst | above or no peak, at worst |"
    )
    print("|---|--:|--:|--:|--:|")
    for low, high in DEVIATIONS:
        std = np.random.default_rng(0).uniform(low, high, (options.rigs, len(Box._fields))).tolist()
        every = zip(np.column_stack(draw_box(options.rigs)).tolist(), std, strict=True)
        shares = np.array([exceeded(z, dict(zip(Box._fields, s, strict=True))) for z, s in every])
        told = shares[np.isfinite(shares).all(1)]
        above, either = told[:, 0], told.sum(1)
        print(
            f"| {low:.0%} to {high:.0%} | {len(told)} of {options.rigs} | {above.mean():.2%} | {above.max():.2%}"
            f" | {either.max():.2%} |",
            flush=True,
        )


if __name__ == "__main__":
    main()
