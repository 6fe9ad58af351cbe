"""A surrogate of the corrected model that a diagnosis leaves; what runs where `labels` are given."""

import hashlib
import json
import time
from functools import partial
from pathlib import Path
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jax.sharding import Mesh

import acf_jax
from acf_jax.contact.peak import Simulated
from acf_jax.contact.read import of_diagnosis
from acf_jax.errors import InputError
from acf_jax.gap_model import GapModel, read_model, write_model
from acf_jax.provenance import Origin
from acf_jax.surrogate.corrected import (
    Bounds,
    CorrectedSurrogate,
    Domain,
    coordinates,
    is_first_peak,
    targets,
)
from acf_jax.surrogate.corrected_file import save_corrected
from acf_jax.surrogate.load import with_dtype
from acf_jax.surrogate.surrogate import Affine
from acf_jax.training.checkpoint import FOLDER, begin, read_state
from acf_jax.training.config import LABELLERS, CorrectedConfig
from acf_jax.training.corrected_report import write_corrected_report
from acf_jax.training.devices import Shards, find_devices, first_alone, is_first
from acf_jax.training.domain import make_domain, to_blame, words
from acf_jax.training.evaluate import of_answer
from acf_jax.training.judge import ask, joined, judge, misled, missed, search_worst, summary
from acf_jax.training.labels import Labels, joined_labels, make_labels, make_simulator
from acf_jax.training.loop import fit_network
from acf_jax.training.progress import Say
from acf_jax.training.results import write_results
from acf_jax.training.versions import versions

MARGIN = 1.2  # of the bounds over the largest errors that held-out samples and the search found
LEAST_SHARE = 0.5  # of impacts whose first peak is the largest force, below which the box is refused
DISTANCE = 0.05  # of the third output above what was seen where the surrogate must not answer


def run(config: CorrectedConfig, resume: bool, say: Say, origin: Origin | None = None) -> dict[str, Any]:
    """Label, train, bound and judge; returns what metrics.json holds."""
    folder, timings, clock = config.output, {}, time.perf_counter
    path = config.labels.model
    gap = read_model(path / "model.json" if path.is_dir() else path)
    between = "a low-pass" if gap.low_pass else "a tool" if gap.tool_mass_kg else ""
    if between and config.labels.force == "sensed":
        raise InputError(
            f"labels.force: is 'sensed', but {between} lies between force and reading of that model, which is not"
            " learnt; take 'contact'"
        )
    model = of_diagnosis(gap, source=str(path))
    model.check_carried()
    law = model.main.peak
    assert isinstance(law, Simulated)
    domain = make_domain(config, model, law)
    if resume and (checkpoint := _checkpoint(config)).exists():
        read_state(checkpoint, _identity(config, gap))  # before labels are made that it may not belong to

    start = clock()
    mesh = find_devices(config)
    if is_first():
        begin(config, resume)
        say(words(domain, config.ranges, config.labels.deviations))
    data = first_alone(lambda: _labels(config, domain, law, gap))
    timings["labels_s"] = clock() - start
    if is_first():
        say(
            f"{sum(len(d.q) for d in data.values()):,} impacts of the corrected model simulated, "
            f"{len(domain.free)} inputs: {', '.join(domain.names[i] for i in domain.free)}"
        )

    start = clock()
    surrogate, losses = _train(config, domain, data["train"], mesh, gap, resume)
    timings["train_s"] = clock() - start

    start = clock()
    wide, simulate = with_dtype(surrogate, float), make_simulator(law, config.labels.force)
    held_out = joined_labels(data["held_out"], data["held_out_edges"])
    even = ask(wide, data["held_out"])  # of the density in which shares are told
    of_held_out = joined([even, ask(wide, data["held_out_edges"])])
    known = [of_held_out, ask(wide, data["train"])]
    known.append(search_worst(wide, simulate, held_out, missed, config.seed))
    tolerance = joined(known).tolerance()
    known.append(search_worst(wide, simulate, held_out, partial(misled, tolerance=tolerance), config.seed))
    seen = joined(known)
    least = max(0.5, float(misled(seen, tolerance).max()) + DISTANCE)
    held = seen.held(least)
    if even.held(least).force.size < LEAST_SHARE * even.force.size:
        why = (
            "the network cannot tell for sure where the force grows beyond its first peak later, which it does in"
            f" {100 * (1 - even.is_first.mean()):.2g} % of the impacts"
        )
        raise InputError(_refusal(domain, data["held_out"].unit, even.is_first, why))
    errors = of_answer(held.force), held.time[held.is_first]
    largest = (MARGIN * float(np.abs(error).max()) for error in errors)
    bounds = Bounds(*(jnp.asarray(value, surrogate.x.scale.dtype) for value in (*largest, least)))
    surrogate = eqx.tree_at(lambda s: s.bounds, surrogate, bounds)
    test = {"box": data["test"], "edges": data["test_edges"]}
    metrics = judge(with_dtype(surrogate, float), test, joined(known[2:]).held(least))
    metrics |= {"losses": losses, "versions": versions()}
    timings["evaluate_s"] = clock() - start
    if not is_first():
        return metrics

    more = {
        "config": config.model_dump(mode="json", exclude={"labels": LABELLERS}),
        "versions": metrics["versions"],
        "errors": metrics["errors"],
    }
    save_corrected(
        folder / "model.eqx", surrogate, config.network, gap.model_dump(mode="json", by_alias=True), more
    )
    write_results(config, metrics, timings, origin)
    write_corrected_report(folder / "report.html", config, domain, law.effects, metrics, timings, origin)
    say(summary(metrics))
    say(f"surrogate: {folder / 'model.eqx'}, report: {folder / 'report.html'}")
    return metrics


def _labels(config: CorrectedConfig, domain: Domain, law: Simulated, gap: GapModel) -> dict[str, Labels]:
    """The samples of every purpose; `InputError` where too few of them have something to learn."""
    identity = {
        "version": acf_jax.__version__,
        "model": _fingerprint(gap),
        "force": config.labels.force,
        "seed": config.seed,
        "samples": config.samples.model_dump(),
        "low": domain.low,
        "high": domain.high,
        "logarithmic": domain.logarithmic,
    }
    identity = json.loads(json.dumps(identity))  # as it comes back from a file
    data = make_labels(config, domain, law, identity)
    first = np.asarray(jax.vmap(is_first_peak)(*map(jnp.asarray, (data["train"].q, *data["train"][3:]))))
    if first.mean() < LEAST_SHARE:
        why = f"in only {100 * first.mean():.0f} % of the impacts is the first peak the largest force within 60 ms"
        raise InputError(_refusal(domain, data["train"].unit, first, why))
    return data


def _refusal(domain: Domain, unit: np.ndarray, is_right: np.ndarray, why: str) -> str:
    """What is wrong with the ranges, beginning with the one that matters most."""
    if (blamed := to_blame(domain, unit, is_right)) is None:
        return f"ranges: {why}; raise the lowest k_c, or lower the highest k_f, d or mobility"
    return f"{blamed[0]}: {why}, the fewer the nearer to one end; {blamed[1]}"


def _train(
    config: CorrectedConfig, domain: Domain, data: Labels, mesh: Mesh, gap: GapModel, resume: bool
) -> tuple[CorrectedSurrogate, list[float]]:
    """A surrogate fitted to the labels, its bounds still unknown, and the mean loss of each chunk of steps."""
    dtype = np.dtype(config.precision)
    columns = tuple(map(jnp.asarray, data[1:]))
    x = jax.jit(jax.vmap(lambda q: coordinates(domain, q)))(columns[0])
    y = jax.jit(jax.vmap(targets))(*columns)
    to_x = Affine((x.max(0) + x.min(0)) / 2, jnp.maximum((x.max(0) - x.min(0)) / 2, 1e-12))
    to_y = Affine(jnp.nanmean(y, 0), jnp.maximum(jnp.nanstd(y, 0), 1e-12))
    scaled = jax.vmap(to_x)(x), jax.vmap(to_y)(y)
    shards = Shards.of(mesh, *(np.asarray(column).astype(dtype) for column in scaled))
    path, identity = _checkpoint(config), _identity(config, gap)
    network, losses = fit_network(
        "corrected", shards, config.network, config.optimiser, config.seed, path, identity, resume
    )
    nothing = Bounds(*(jnp.zeros(()) for _ in range(3)))
    surrogate = CorrectedSurrogate(network, to_x, to_y, nothing, domain, config.labels.force)
    return with_dtype(surrogate, dtype), losses


def _checkpoint(config: CorrectedConfig) -> Path:
    return config.output / FOLDER / "corrected.eqx"


def _identity(config: CorrectedConfig, gap: GapModel) -> dict[str, Any]:
    """What the state of a run depends on."""
    return config.identity() | {"model": _fingerprint(gap)}


def _fingerprint(gap: GapModel) -> str:
    return hashlib.sha256(write_model(gap).encode()).hexdigest()
