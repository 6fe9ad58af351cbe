"""The exact peak force, a million at a time: JAX against numba, SciPy, optimistix and diffrax.

    python -m benchmarks.peak_speed

Same inputs, same cores, one run, interleaved. Every peer finds the root to the same tolerance; those
that cannot do a million in reasonable time get fewer samples, and time a sample is compared.
"""

import argparse
import json
import os
import statistics
from collections.abc import Sequence
from pathlib import Path
from typing import Any

# OpenMP threads that spin after numba's loop would take the cores from the next peer.
os.environ.setdefault("OMP_WAIT_POLICY", "passive")

import jax
import numpy as np

from benchmarks.box import Box, draw_box, take
from benchmarks.machine import cores, describe
from benchmarks.peers import mpmath_peak
from benchmarks.peers.bracket import bracket
from benchmarks.peers.peer import Peer
from benchmarks.timing import interleave

TOLERANCE = 1e-12  # of omega t_max; F_max is stationary there and gains twice as many digits
TRUTH = 200  # samples compared with mpmath


def build_peaks(box: Box) -> list[Peer]:
    """All peers; the slow ones get fewer samples."""
    from benchmarks.peers import jax_peak, numba_peak, scipy_peak

    some, few = take(box, slice(200_000)), take(box, slice(20_000))
    return [
        jax_peak.exact(box),
        *numba_peak.peers(box),
        jax_peak.optimistix_route(box),
        jax_peak.optimistix_newton(box, TOLERANCE),
        jax_peak.optimistix_bisection(some, TOLERANCE),
        scipy_peak.elementwise_find_root(box, bracket(box), TOLERANCE),
        jax_peak.diffrax_event(few, bracket(few), TOLERANCE),
        scipy_peak.brentq_loop(few, bracket(few), TOLERANCE),
        scipy_peak.brentq_processes(few, bracket(few), TOLERANCE),
    ]


def build_gradients(box: Box) -> list[Peer]:
    """The gradient by the envelope theorem and through the root find, on the samples with a peak."""
    from benchmarks.peers import jax_peak

    some = take(box, slice(100_000))
    return [
        jax_peak.envelope_gradient(box, bracket(box)),
        jax_peak.implicit_gradient(box, bracket(box), TOLERANCE),
        jax_peak.unrolled_gradient(some, bracket(some), TOLERANCE),
    ]


def measure(
    peers: Sequence[Peer], repeats: int, baseline: str, truth: dict[int, Any]
) -> list[dict[str, Any]]:
    """One row a peer: nanoseconds a sample, ratio to the baseline, largest relative error."""
    seconds = interleave({peer.name: peer.call for peer in peers}, repeats)
    per_sample = {p.name: [1e9 * s / len(p.chosen) for s in seconds[p.name]] for p in peers}
    rows = []
    for peer in peers:
        own = per_sample[peer.name]
        ratios = [b / o for b, o in zip(per_sample[baseline], own, strict=True)]
        found = dict(zip(peer.chosen.tolist(), peer.answers(peer.call()).T, strict=True))
        errors = [np.abs(found[i] / exact - 1) for i, exact in truth.items() if i in found]
        rows.append(
            {
                "peer": peer.name,
                "samples": len(peer.chosen),
                "ns": statistics.median(own),
                "ns_min": min(own),
                "ns_max": max(own),
                "ratio": statistics.median(ratios),
                "errors": np.max(errors, axis=0).tolist() if errors else [],
            }
        )
    return rows


def table(rows: list[dict[str, Any]], ratio: str, errors: str) -> str:
    """The rows in Markdown; `errors` heads one column a kind of error."""
    heads = f"| | samples | ns a sample | min … max | {ratio} | {errors} |"
    lines = [heads, "|---" + "|--:" * (heads.count("|") - 2) + "|"]
    for r in rows:
        off = " | ".join(f"{error:.0e}" for error in r["errors"])
        lines.append(
            f"| {r['peer']} | {r['samples']:,} | {r['ns']:,.0f} | {r['ns_min']:,.0f} … {r['ns_max']:,.0f} "
            f"| {r['ratio']:.2g} | {off} |"
        )
    return "\n".join(lines)


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.peak_speed", description=__doc__.splitlines()[0]
    )
    parser.add_argument("--batch", type=int, default=1_000_000, help="samples (default: 1000000)")
    parser.add_argument("--repeats", type=int, default=15, help="interleaved rounds (default: 15)")
    parser.add_argument("--json", type=Path, help="write the rows to this file, too")
    options = parser.parse_args(arguments)
    jax.config.update("jax_enable_x64", True)
    jax.config.update("jax_num_cpu_devices", cores())

    box = draw_box(options.batch)
    with_peak = np.sort(bracket(take(box, slice(2 * TRUTH))).chosen)[:TRUTH]
    truth = dict(zip(with_peak.tolist(), mpmath_peak.peaks(box, with_peak).T, strict=True))
    slopes = dict(zip(with_peak.tolist(), mpmath_peak.slope_in_f_p(box, with_peak).T, strict=True))

    peers = build_peaks(box)
    baseline = peers[2].name
    peaks = measure(peers, options.repeats, baseline, truth)
    gradients = build_gradients(box)
    gradient_rows = measure(gradients, max(3, options.repeats // 3), gradients[1].name, slopes)
    print(f"{options.batch:,} samples, float64, root tolerance {TOLERANCE:g}; {describe()}\n")
    print(table(peaks, f"× {baseline}", "error of F_max | error of t_max"))
    print("\nGradient of F_max with respect to all six parameters:\n")
    print(table(gradient_rows, "× implicit", "error of dF_max/dF_P"))
    if options.json:
        options.json.write_text(json.dumps({"peaks": peaks, "gradients": gradient_rows}, indent=1))


if __name__ == "__main__":
    main()
