"""The error of a surrogate against the model, on samples that training never saw."""

from typing import Any, NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np

from acf_jax.model import Impact, Rig, find_peak
from acf_jax.surrogate import Surrogate
from acf_jax.surrogate.box import UNITS
from acf_jax.surrogate.fold import distance_to_fold
from acf_jax.training.config import Config
from acf_jax.training.data import Labelled

BOUND_BINS = 10
MAP_CELLS = 20
LEAST = 100  # samples with a peak that a purpose needs
# the paper's Table 1: contact velocity in m/s, pretension in N, peak force measured and by its model in N
TABLE1 = (
    (0.05, 100.0, 110.0, 108.0),
    (0.1, 100.0, 137.0, 130.0),
    (0.2, 100.0, 198.0, 195.0),
    (0.3, 100.0, 282.0, 271.0),
    (0.35, 100.0, 320.0, 310.0),
)


class Answers(NamedTuple):
    """What a surrogate says of the samples that have a peak."""

    error: np.ndarray  # F_surrogate/F_model - 1
    bound: np.ndarray  # stated by the surrogate, relative to F_model
    u: np.ndarray  # distance from the fold


def ask(surrogate: Surrogate, data: Labelled) -> Answers:
    """The surrogate's answers to the samples that have a peak."""
    force, bound, u = (np.asarray(value)[data.has_peak] for value in _ask(surrogate, data.rig, data.impact))
    return Answers(force / data.f_max - 1, bound / data.f_max, u)


def of_answer(error: np.ndarray) -> np.ndarray:
    """Errors F_s/F - 1 as shares of the surrogate's force, which its bound is a share of: F/F_s - 1."""
    return -error / (1 + error)


def too_few(sizes: dict[str, dict[str, int]]) -> list[str]:
    """What is wrong with ranges in which hardly any sample has a peak; `sizes` by purpose."""
    return [
        f"ranges: of the {sum(size.values()):,} samples for `{purpose}` {size['with_peak']:,} have a peak, and at "
        f"least {LEAST} must; lower the highest zeta or k_f, or raise the lowest k_c or f_p"
        for purpose, size in sizes.items()
        if size["with_peak"] < LEAST
    ]


@eqx.filter_jit
def _ask(surrogate: Surrogate, rig: Rig, impact: Impact) -> tuple[jax.Array, jax.Array, jax.Array]:
    def one(rig: Rig, impact: Impact) -> tuple[jax.Array, jax.Array, jax.Array]:
        fold = distance_to_fold(rig, impact)
        return surrogate.force(rig, impact), surrogate.error_bound(rig, impact), fold.u

    return jax.vmap(one)(rig, impact)


def judge(
    config: Config, surrogates: dict[str, Surrogate], train: dict[str, int], test: dict[str, Labelled]
) -> dict[str, Any]:
    """Everything the report says about errors, as plain numbers, for each feature set; `train`: its sizes."""
    metrics: dict[str, Any] = {
        "features": config.features,
        "samples": {"train": train, **{name: data.sizes() for name, data in test.items()}},
        "errors": {},
        "distribution": {},
    }
    for name, surrogate in surrogates.items():
        answers = {density: ask(surrogate, data) for density, data in test.items()}
        sizes = [leaf.size for leaf in jax.tree.leaves(eqx.filter(surrogate.network, eqx.is_array))]
        metrics["errors"][name] = {"parameters": sum(sizes)} | {
            density: figures(*answers[density][:2], test[density].f_max) for density in test
        }
        metrics["distribution"][name] = distribution(answers["box"].error)
        if name == config.features:
            held_out = surrogate.held_out
            metrics["bound"] = {"u": held_out.edges.tolist(), "relative": held_out.largest.tolist()}
            columns = _columns(test["box"], answers["box"])
            metrics["map"] = _maps(columns)
            metrics["worst"] = _worst(columns)
    return metrics


def figures(error: np.ndarray, bound: np.ndarray, f_max: np.ndarray) -> dict[str, Any]:
    """Quantiles and extremes of a relative error, also in newtons, and how often its bound failed."""

    def of(value: np.ndarray) -> dict[str, float]:
        size = np.abs(value)
        median, p99, p999 = np.quantile(size, [0.5, 0.99, 0.999]).tolist()
        return {
            "median": median,
            "p99": p99,
            "p99_9": p999,
            "max": float(size.max()),
            "largest_under_prediction": float(max(0.0, -value.min())),
        }

    return {
        "relative": of(error),
        "newton": of(error * f_max),
        "above_bound": int((np.abs(error) > bound).sum()),
        "samples": error.size,
    }


def distribution(error: np.ndarray) -> dict[str, list[float]]:
    """The share of samples whose error is larger, at the errors of evenly spaced shares (log scale)."""
    shares = np.geomspace(1, 1 / error.size, 60)
    return {"share": shares.tolist(), "error": np.quantile(np.abs(error), 1 - shares).tolist()}


def _columns(data: Labelled, answers: Answers) -> dict[str, np.ndarray]:
    """Parameters, dimensionless groups (p as p/sqrt(p^2 + kappa)), peak force and error of each sample."""
    rig, impact = data.rig, data.impact
    undamped = jnp.sqrt(impact.f_p**2 + rig.k_c * rig.m * impact.v_e**2)
    all_samples = dict(zip(UNITS, (rig.m, rig.zeta, rig.k_f, rig.k_c, impact.v_e, impact.f_p), strict=True))
    all_samples |= {"kappa": rig.k_c / rig.k, "share": impact.f_p / undamped, "f_max": data.peak.f_max}
    columns = {name: np.asarray(column)[data.has_peak] for name, column in all_samples.items()}
    return columns | {"u": answers.u, "relative_error": answers.error}


def _maps(columns: dict[str, np.ndarray]) -> list[dict[str, Any]]:
    """The largest error in each cell of a plane of two groups; None where no sample falls."""
    maps = []
    for plane in (("zeta", "u"), ("zeta", "kappa"), ("share", "zeta")):
        spans = [(float(columns[name].min()), float(columns[name].max())) for name in plane]
        across, up = (
            ((columns[name] - low) / (high - low) * MAP_CELLS).astype(int).clip(0, MAP_CELLS - 1)
            for name, (low, high) in zip(plane, spans, strict=True)
        )
        largest = np.full((MAP_CELLS, MAP_CELLS), -1.0)
        np.maximum.at(largest, (up, across), np.abs(columns["relative_error"]))
        rows = [[None if value < 0 else float(f"{value:.3g}") for value in row] for row in largest]
        maps.append({"across": plane[0], "up": plane[1], "range": spans, "largest": rows})
    return maps


def _worst(columns: dict[str, np.ndarray], count: int = 10) -> list[dict[str, float]]:
    """The samples with the largest relative errors, worst first."""
    order = np.argsort(-np.abs(columns["relative_error"]), kind="stable")[:count]
    return [{name: float(column[i]) for name, column in columns.items()} for i in order]


def table1(config: Config, surrogate: Surrogate) -> list[dict[str, Any]]:
    """The paper's Table 1 beside this model and this surrogate, for the rig in the configuration."""
    if config.table1 is None:
        return []
    rig = Rig(**config.table1.rig.model_dump())
    rows = []
    for v_e, f_p, measured, of_paper in TABLE1:
        impact = Impact(v_e=v_e, f_p=f_p)
        prediction = surrogate(rig, impact, outside="flag")
        rows.append(
            {
                "v_e": v_e,
                "measured": measured,
                "paper_model": of_paper,
                "model": float(find_peak(rig, impact).f_max),
                "surrogate": float(prediction.f_max),
                "bound": float(prediction.error_bound) if prediction.is_inside else None,
            }
        )
    return rows


def error_table(what: str, errors: dict[str, Any]) -> list[str]:
    """Errors by name as lines for a terminal."""
    lines = ["", "Relative error of the peak force on fresh samples (even density over the box)"]
    lines.append(
        f"{what:>14} {'median':>9} {'p99':>9} {'p99.9':>9} {'max':>9} {'largest under-prediction':>26}"
    )
    for name, error in errors.items():
        relative, newton = error["relative"], error["newton"]
        numbers = " ".join(f"{relative[key]:9.1e}" for key in ("median", "p99", "p99_9", "max"))
        under = f"{relative['largest_under_prediction']:.1e}, {newton['largest_under_prediction']:.1e} N"
        lines.append(f"{name:>14} {numbers} {under:>26}")
    return lines


def summary(metrics: dict[str, Any]) -> str:
    """The errors and Table 1 as text for a terminal."""
    lines = error_table("features", {name: error["box"] for name, error in metrics["errors"].items()})
    if metrics["table1"]:
        lines += ["", "Table 1 of the paper, F_P = 100 N, peak force in N"]
        lines.append("v_E (m/s)   measured   paper's model   this model   surrogate   error bound")
        for row in metrics["table1"]:
            bound = "outside its range" if row["bound"] is None else f"{row['bound']:.1e}"
            lines.append(
                f"{row['v_e']:9.2f} {row['measured']:10.0f} {row['paper_model']:15.0f} {row['model']:12.2f} "
                f"{row['surrogate']:11.2f}   {bound:>11}"
            )
    return "\n".join(lines)
