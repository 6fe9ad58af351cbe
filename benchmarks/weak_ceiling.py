"""What caution costs: how many weak effects the best method names if it shall raise few false alarms.

python -m benchmarks.weak_ceiling --seed 2055 --cases 400 --forms 4

Draws the weak effects of a blind run anew. For each the Bayes decision of `validation.blind.ceiling`, which is told the
rig, the noise and the true form, is made at several prices: how many times more probable than none an effect has to be.
"""

import argparse
from collections.abc import Sequence

import numpy as np

from benchmarks.machine import describe
from validation.blind.ceiling import FORMS, signals, weigh
from validation.blind.plan import WEAK, draw_plan
from validation.worlds import find_world, make_case

PRICES = (1.0, 2.0, 3.0, 5.0, 10.0, 20.0, 50.0)


def main(arguments: Sequence[str] | None = None) -> None:
    """Draw, decide, print."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.weak_ceiling", description=__doc__.splitlines()[0]
    )
    parser.add_argument("--seed", type=int, default=2055)
    parser.add_argument("--cases", type=int, default=400, help="of the run whose weak effects are drawn")
    parser.add_argument(
        "--forms", type=int, default=FORMS, help="in which each effect is drawn beside the true one"
    )
    chosen = parser.parse_args(arguments)
    print(describe())
    plan = draw_plan(chosen.seed, chosen.cases, [find_world("scipy"), find_world("mujoco")])
    rows = []
    for order in plan:
        if order.kind != "single" or order.target is None or order.target >= WEAK[1]:
            continue
        case = make_case(order.seed, order.effects, None, order.target, order.world, order.coloured)
        if case.distance >= WEAK[1]:
            continue
        gram, labels, rng = signals(case, chosen.forms)
        odds, right = weigh(gram, labels, case.distance, rng)
        odds_of_none, _ = weigh(gram, labels, 0.0, rng)
        rows.append([((right & (odds > price)).mean(), (odds_of_none > price).mean()) for price in PRICES])
    named, alarms = np.mean(rows, 0).T
    print(f"{len(rows)} weak effects of seed {chosen.seed}")
    print("price   named   of the best   false alarms")
    for row in zip(PRICES, named, named / named[0], alarms, strict=True):
        print("{:5.0f}   {:5.2f}   {:11.0%}   {:12.1%}".format(*row))


if __name__ == "__main__":
    main()
