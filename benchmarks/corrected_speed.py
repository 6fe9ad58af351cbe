"""A surrogate of a corrected model against the fastest simulation of it that reaches 0.1 %.

    python -m benchmarks.corrected_speed --model artifacts/closed_loop/model.eqx

Steps, blocks and solvers are swept; of those within 0.1 % of the reference the fastest counts. All on all cores.
"""

import argparse
import statistics
import time
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import diffrax
import jax
import jax.numpy as jnp
import numpy as np
import optimistix as optx
from jax.flatten_util import ravel_pytree

from acf_jax.contact.body import Body
from acf_jax.contact.model_file import ModelFile
from acf_jax.contact.peak import Simulated
from acf_jax.contact.recoil import Recoil
from acf_jax.inference.forward import SAMPLES, unpack
from acf_jax.model import Impact
from acf_jax.predict import LONGEST
from acf_jax.simulator import largest_force, simulate
from acf_jax.simulator.simulate import at_rest, make_system
from acf_jax.start import start_jax
from acf_jax.surrogate import CorrectedSurrogate
from acf_jax.surrogate.load import with_dtype
from benchmarks.machine import cores, describe
from benchmarks.peers.jax_peak import on_all_cores
from benchmarks.timing import interleave, median_ratio, summarise

GOOD = 1e-3
REFERENCE = 0.01  # omega h
STEPS = (0.1, 0.2, 0.3, 0.4, 0.5)  # omega h
TOLERANCES = (1e-2, 1e-3, 1e-4)
BLOCKS = (64, 256, 1024, 4096)
CALLS = 2000

One = Callable[[jax.Array], jax.Array]  # q to the force


def main(argv: Sequence[str] | None = None) -> None:
    """Print the candidates with their errors, then the surrogate and its ratios."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.corrected_speed")
    parser.add_argument("--model", type=Path, default=Path("artifacts/closed_loop/model.eqx"))
    parser.add_argument("--samples", type=int, default=32768)
    parser.add_argument("--repeats", type=int, default=7)
    arguments = parser.parse_args(argv)
    jax.config.update("jax_num_cpu_devices", cores())  # before start_jax asks for the devices
    start_jax()
    model, surrogate = ModelFile(arguments.model).load_exact()
    law = model.main.peak
    assert isinstance(law, Simulated) and surrogate is not None
    domain = surrogate.domain
    q = domain.at(np.random.default_rng(0).random((arguments.samples, len(domain.free))))
    exact = _run(on_all_cores(_blocked(partial(_lean, law.effects, REFERENCE), 1024), q))

    print(describe())
    print(
        f"{', '.join(law.effects)}: {arguments.samples:,} impacts over the surrogate's {len(domain.free)} inputs\n"
    )
    print("| simulation | setting | largest error | block | µs an impact | µs one call |")
    print("|---|---|--:|--:|--:|--:|")
    candidates = {
        ("with its trace, as `predict` does", "the file's step"): partial(_traced, law),
        ("largest force only, as labels are made", "the file's step"): partial(_own, law),
        **{("largest force only", f"ωh = {a}"): partial(_lean, law.effects, a) for a in STEPS},
        **{
            ("diffrax Tsit5 to the first peak", f"tolerance {t:g}"): partial(_adaptive, law.effects, t)
            for t in TOLERANCES
        },
    }
    fit: dict[str, tuple[float, Callable[[], Any], float]] = {}
    for (name, setting), one in candidates.items():
        slow = name.startswith(("with its", "diffrax"))
        share = q[: len(q) // 8] if slow else q
        calls, spent = _sweep(one, share, 3)
        best = min(BLOCKS, key=spent.__getitem__)
        error = float(np.abs(_run(calls[best]) / exact[: len(share)] - 1).max())
        single = _single(one, q)
        print(
            f"| {name} | {setting} | {error:.1e} | {best:,} | {1e6 * spent[best]:.2f} | {single:.0f} |",
            flush=True,
        )
        if error <= GOOD and not slow:
            fit[f"{name}, {setting}"] = spent[best], calls[best], single
        elif error <= GOOD:
            fit[f"{name}, {setting}"] = spent[best], on_all_cores(_blocked(one, best), q), single
    _compare(surrogate, q, exact, fit)


def _compare(
    surrogate: CorrectedSurrogate,
    q: np.ndarray,
    exact: np.ndarray,
    fit: dict[str, tuple[float, Callable[[], Any], float]],
) -> None:
    batch = min(fit, key=lambda name: fit[name][0])
    single = min(fit, key=lambda name: fit[name][2])
    print(f"\nFastest within 0.1 %: {batch} in a batch, {single} for one call.\n")
    print("| surrogate | largest error | block | ns an impact | × simulation | µs one call | × simulation |")
    print("|---|--:|--:|--:|--:|--:|--:|")
    for dtype in (jnp.float64, jnp.float32):
        ours = with_dtype(surrogate, dtype)

        def one(q: jax.Array, ours: CorrectedSurrogate = ours) -> jax.Array:
            return ours(q)[0]

        own = q.astype(dtype)
        calls, spent = _sweep(one, own, 5, _in_columns)
        best = min(BLOCKS, key=spent.__getitem__)
        error = float(np.abs(_run(calls[best]) / exact - 1).max())
        seconds = interleave({"ours": calls[best], "simulation": fit[batch][1]}, 9)
        ratio = median_ratio(seconds["simulation"], seconds["ours"])
        call = _single(one, own)
        nanoseconds = 1e9 * summarise(seconds["ours"]).median / len(q)
        print(
            f"| {np.dtype(dtype).name} | {error:.1e} | {best:,} | {nanoseconds:.0f} | {ratio:.0f} | {call:.1f} |"
            f" {fit[single][2] / call:.0f} |",
            flush=True,
        )


def _sweep(
    one: One, q: np.ndarray, repeats: int, mapped: Callable[[One, int], One] | None = None
) -> tuple[dict[int, Callable[[], Any]], dict[int, float]]:
    """A call of the batch, and its seconds a sample, for each size of block."""
    calls = {block: on_all_cores((mapped or _blocked)(one, block), q) for block in BLOCKS}
    seconds = interleave({str(block): call for block, call in calls.items()}, repeats)
    return calls, {block: summarise(seconds[str(block)]).median / len(q) for block in BLOCKS}


def _blocked(one: One, block: int) -> Callable[[jax.Array], jax.Array]:
    return lambda q: jax.lax.map(one, q, batch_size=block)


def _in_columns(one: One, block: int) -> Callable[[jax.Array], jax.Array]:
    """The same of a function that takes samples as columns; the rows come as of every peer."""
    return lambda q: jax.lax.map(lambda rows: one(rows.T), q.reshape(-1, block, q.shape[-1])).reshape(-1)


def _run(call: Callable[[], Any]) -> np.ndarray:
    return np.concatenate([np.asarray(part) for part in call()])


def _single(one: One, q: np.ndarray) -> float:
    """Microseconds of one call in Python, a NumPy vector in, a number out: the median."""
    program = jax.jit(one)
    samples = list(q[:CALLS])
    for sample in samples[:50]:
        float(program(sample))
    spent = []
    for sample in samples:
        start = time.perf_counter_ns()
        float(program(sample))
        spent.append((time.perf_counter_ns() - start) / 1e3)
    return statistics.median(spent)


def _own(law: Simulated, q: jax.Array) -> jax.Array:
    return law(q[:-1], Body(0.0, q[-1])).force


def _traced(law: Simulated, q: jax.Array) -> jax.Array:
    """Every sample of the trace is kept, and the largest taken from it afterwards."""
    rig, effects = unpack(law.effects, q[:-3])
    h = jnp.maximum(law.longest_step, LONGEST / (SAMPLES - 4))
    steps = (LONGEST / h).astype(int) + 1
    force = simulate(rig, Impact(q[-3], q[-2]), [*effects, Recoil(q[-1])], h, SAMPLES, steps).contact
    lost = jnp.cumsum((force <= 0) & (jnp.arange(SAMPLES) <= steps)) > 0
    return jnp.where(lost, 0.0, force).max()


def _lean(effects: tuple[str, ...], angle: float, q: jax.Array) -> jax.Array:
    """`largest_force` with omega h = `angle`."""
    rig, built = unpack(effects, q[:-3])
    h = angle / jnp.sqrt((rig.k_f + rig.k_c) * (1 / rig.m + q[-1]))
    return largest_force(rig, Impact(q[-3], q[-2]), [*built, Recoil(q[-1])], h, LONGEST).force


def _adaptive(effects: tuple[str, ...], tolerance: float, q: jax.Array) -> jax.Array:
    """diffrax, stopped at the first instant at which the contact is not compressed further."""
    rig, built = unpack(effects, q[:-3])
    impact = Impact(q[-3], q[-2])
    system = make_system(rig, impact, [*built, Recoil(q[-1])], 1.0)
    holding = [f for e in system.effects if (f := e.release_force(impact)) is not None]
    release = jnp.stack(holding).max() if holding else jnp.asarray(-jnp.inf)

    y_0, state_of = ravel_pytree(at_rest(system.effects))

    def rates(t: Any, y: Any, args: Any) -> Any:
        state = state_of(y)
        is_free = (state.x != 0) | (system.motion(t, state).f_c >= release)
        return ravel_pytree(system.rates(t, state, is_free.astype(float)))[0]

    def compressing(t: Any, y: Any, args: Any, **_: Any) -> jax.Array:
        return system.motion(t, state_of(y)).s_dot

    omega = jnp.sqrt((rig.k_f + rig.k_c) * (1 / rig.m + q[-1]))
    found = diffrax.diffeqsolve(
        diffrax.ODETerm(rates),
        diffrax.Tsit5(),
        0.0,
        LONGEST,
        0.3 / omega,
        y_0,
        stepsize_controller=diffrax.PIDController(rtol=tolerance, atol=tolerance * 1e-3),
        event=diffrax.Event(compressing, optx.Newton(1e-5, 1e-5, optx.rms_norm)),
        max_steps=256,
        throw=False,
    )
    assert found.ts is not None
    return system.motion(found.ts[-1], state_of(found.ys[-1])).f_c


if __name__ == "__main__":
    main()
