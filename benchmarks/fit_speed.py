"""The fits of `diagnose` against the same fits by SciPy: `least_squares` over `solve_ivp`.

python -m benchmarks.fit_speed
python -m benchmarks.fit_speed --programs --repeats 21    of the simulations with derivatives alone
python -m benchmarks.fit_speed --lengths --repeats 21     the same of trials a few of which last longer
"""

import argparse
import json
import time
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import jax
import numpy as np

from acf_jax.dataset import assess_dataset
from acf_jax.diagnosis.candidates import fit_nominal, fit_single
from acf_jax.inference.baseline import Ground
from acf_jax.inference.fit import Fit
from acf_jax.inference.forward import BLOCKS, Grid, block_for, forward
from acf_jax.inference.free_curves import free_curves
from acf_jax.inference.observations import Observations, observe
from acf_jax.inference.parameters import Explanation, label, starts
from benchmarks.drawn_set import draw_set
from benchmarks.machine import describe
from benchmarks.peers import scipy_fit
from benchmarks.timing import median_ratio, summarise

EXPLANATIONS: tuple[Explanation, ...] = ((), ("coulomb_friction",), ("sensor_lag",), ("robot_compliance",))
PEERS = {
    "a solve_ivp an impact": partial(scipy_fit.fit, simulate=scipy_fit.one_by_one),
    "one solve_ivp for all impacts": partial(scipy_fit.fit, simulate=scipy_fit.all_at_once),
}

RIG = np.array([3.0, 30.0, 1e3, 1.2e5])  # m, d, k_F, k_C in SI units
STEPS = Grid(2e-4, 150)
REACH = 150.0  # N
LENGTHS = np.repeat([600, 100], [4, 16])  # steps of each trial


def own_fit(observations: Observations, explanation: Explanation) -> Fit:
    """The fit of `diagnose`, from all its starts."""
    nominal = fit_nominal(observations)
    return fit_single(Ground.of(observations, nominal), explanation[0]) if explanation else nominal


def timed(call: Callable[[], Any]) -> tuple[float, Any]:
    """Seconds and result of a call."""
    begin = time.perf_counter()
    result = call()
    return time.perf_counter() - begin, result


def cpu_ms(call: Callable[[], Any]) -> float:
    """CPU time of a call, all threads: a wall clock would measure the machine's other work, too."""
    started = time.process_time()
    call()
    return 1e3 * (time.process_time() - started)


def measure(observations: Observations, explanation: Explanation, repeats: int) -> dict[str, Any]:
    """Seconds and objective of each, in turn within every round, so that all meet the same moments of the machine."""
    compiling, _ = timed(lambda: own_fit(observations, explanation))
    seconds: dict[str, list[float]] = {name: [] for name in ("acf_jax", *PEERS)}
    objective: dict[str, float] = {}
    for _ in range(repeats):
        for name in seconds:
            solve = PEERS.get(name, own_fit)
            spent, answer = timed(partial(solve, observations, explanation))
            seconds[name].append(spent)
            objective[name] = answer.objective
    return {
        "explanation": label(explanation),
        "first": compiling,
        "seconds": seconds,
        "objective": objective,
        "ratio": {name: median_ratio(seconds[name], seconds["acf_jax"]) for name in PEERS},
    }


def program_table(repeats: int) -> str:
    """CPU time of one block of trials."""
    lines = ["| program | ms, median | min … max |", "|---|--:|--:|"]
    v_e, f_p = np.linspace(0.05, 0.3, BLOCKS[0]), np.linspace(20.0, 100.0, BLOCKS[0])
    for explanation in (*EXPLANATIONS, *((name,) for name in free_curves())):
        theta = np.concatenate([RIG, *(starts(name)[0] for name in explanation)])
        call = partial(forward, explanation, theta, v_e, f_p, STEPS, REACH)
        call()  # compiles
        t = summarise([cpu_ms(call) for _ in range(repeats)])
        lines.append(f"| {label(explanation)} | {t.median:.1f} | {t.low:.1f} … {t.high:.1f} |")
    return "\n".join(lines)


def lengths_table(repeats: int) -> str:
    """CPU time of trials of which four last six times as long as the others, each as long as it is, and all as long."""
    lines = ["| program | all as long, ms | each as long as it is, ms | × |", "|---|--:|--:|--:|"]
    v_e, f_p = np.linspace(0.05, 0.3, LENGTHS.size), np.linspace(20.0, 100.0, LENGTHS.size)
    alike = np.full_like(LENGTHS, LENGTHS.max())
    for explanation in (*EXPLANATIONS, ("contact_hardening", "sensor_resonance")):
        theta = np.concatenate([RIG, *(starts(name)[0] for name in explanation)])
        spent: dict[bool, list[float]] = {False: [], True: []}
        for _ in range(repeats + 1):  # the first compiles
            for own, steps in ((False, alike), (True, LENGTHS)):
                grid = STEPS._replace(steps=int(steps.max()), block=block_for(steps))
                call = partial(forward, explanation, theta, v_e, f_p, grid, REACH, steps=steps)
                spent[own].append(cpu_ms(call))
        whole, each = (summarise(spent[own][1:]).median for own in (False, True))
        ratio = median_ratio(spent[False][1:], spent[True][1:])
        lines.append(f"| {label(explanation)} | {whole:.1f} | {each:.1f} | {ratio:.1f} |")
    return "\n".join(lines)


def table(rows: list[dict[str, Any]]) -> str:
    """Seconds, ratios and objectives in Markdown."""
    lines = [
        "| fit | by | s, median | min … max | × acf_jax | objective |",
        "|---|---|--:|--:|--:|--:|",
    ]
    for row in rows:
        for name, seconds in row["seconds"].items():
            t, ratio = summarise(seconds), row["ratio"].get(name, 1.0)
            lines.append(
                f"| {row['explanation']} | {name} | {t.median:.3g} | {t.low:.3g} … {t.high:.3g} "
                f"| {ratio:.0f} | {row['objective'][name]:.1f} |"
            )
    for name in rows[0]["seconds"]:
        total, own = ([sum(r) for r in rounds(rows, by)] for by in (name, "acf_jax"))
        t, ratio = summarise(total), median_ratio(total, own)
        lines.append(
            f"| all together | {name} | {t.median:.3g} | {t.low:.3g} … {t.high:.3g} | {ratio:.0f} | |"
        )
    return "\n".join(lines)


def rounds(rows: list[dict[str, Any]], name: str) -> list[tuple[float, ...]]:
    """Seconds of every fit, round by round."""
    return list(zip(*(row["seconds"][name] for row in rows), strict=True))


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.fit_speed", description=__doc__.splitlines()[0]
    )
    parser.add_argument("--trials", type=int, default=20, help="traces in the drawn set (default: 20)")
    parser.add_argument("--repeats", type=int, default=3, help="interleaved rounds (default: 3)")
    parser.add_argument("--json", type=Path, help="write the rows to this file, too")
    parser.add_argument("--programs", action="store_true", help="one block of simulated trials, no fit")
    parser.add_argument("--lengths", action="store_true", help="simulated trials of unlike length, no fit")
    options = parser.parse_args(arguments)
    jax.config.update("jax_enable_x64", True)
    if options.programs:
        print(f"{BLOCKS[0]} trials, {STEPS.steps} steps, {options.repeats} runs; {describe()}\n")
        print(program_table(options.repeats))
        return
    if options.lengths:
        print(f"{LENGTHS.size} trials, {options.repeats} runs; {describe()}\n")
        print(lengths_table(options.repeats))
        return
    dataset = draw_set(options.trials)
    observations = observe(assess_dataset(dataset))
    rows = [measure(observations, explanation, options.repeats) for explanation in EXPLANATIONS]
    print(
        f"{options.trials} traces, {observations.n_used:,} samples, {options.repeats} rounds; {describe()}\n"
    )
    print(table(rows))
    first = ", ".join(f"{row['first']:.1f}" for row in rows)
    print(f"\nThe first fit of each by acf_jax, its compilation included: {first} s.")
    if options.json:
        options.json.write_text(json.dumps(rows, indent=1))


if __name__ == "__main__":
    main()
