"""The error of a surrogate against the model, on samples that training never saw."""

from typing import Any

import jax
import numpy as np

from acf_jax.model import Impact, Rig, find_peak
from acf_jax.surrogate import Surrogate
from acf_jax.surrogate.box import UNITS
from acf_jax.surrogate.fold import distance_to_fold
from train.config import Config
from train.data import Labelled

BOUND_BINS = 10
MAP_CELLS = 20
# Table 1 of the paper, F_P = 100 N: contact velocity (m/s), peak force of its model and measured (N)
TABLE1_F_P = 100.0
TABLE1 = ((0.05, 108, 110), (0.1, 130, 137), (0.2, 195, 198), (0.3, 271, 282), (0.35, 310, 320))


def relative_error(surrogate: Surrogate, data: Labelled) -> np.ndarray:
    """F_surrogate/F_model - 1 of each sample."""
    force = jax.jit(jax.vmap(surrogate.force))(data.rig, data.impact)
    return np.asarray(force / data.peak.f_max - 1)


def fold_distance(data: Labelled) -> np.ndarray:
    """u of each sample: 0 where the peak is about to disappear."""
    return np.asarray(jax.jit(jax.vmap(distance_to_fold))(data.rig, data.impact).u)


def judge(
    config: Config, surrogates: dict[str, Surrogate], train: Labelled, test: dict[str, Labelled]
) -> dict[str, Any]:
    """Everything the report says about errors, as plain numbers, for each feature set."""
    metrics: dict[str, Any] = {
        "features": config.features,
        "samples": {
            name: {"with_peak": data.size, "without_peak": data.without_peak}
            for name, data in {"train": train, **test}.items()
        },
        "errors": {},
        "distribution": {},
    }
    for name, surrogate in surrogates.items():
        errors = {density: relative_error(surrogate, data) for density, data in test.items()}
        metrics["errors"][name] = {
            density: _figures(error, test[density], surrogate) for density, error in errors.items()
        } | {
            "parameters": sum(
                leaf.size for leaf in jax.tree.leaves(surrogate.network) if hasattr(leaf, "size")
            )
        }
        metrics["distribution"][name] = _distribution(errors["box"])
        if name == config.features:
            held_out = surrogate.held_out
            metrics["bound"] = {"u": held_out.edges.tolist(), "relative": held_out.largest.tolist()}
            metrics["map"] = _maps(errors["box"], test["box"])
            metrics["worst"] = _worst(errors["box"], test["box"])
    return metrics


def _figures(error: np.ndarray, data: Labelled, surrogate: Surrogate) -> dict[str, Any]:
    """Quantiles and extremes of the error, relative and in newtons, and how often the bound failed."""
    force = np.asarray(data.peak.f_max)
    bound = np.asarray(jax.jit(jax.vmap(surrogate.error_bound))(data.rig, data.impact))

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
        "newton": of(error * force),
        "above_bound": int((np.abs(error) * force > bound).sum()),
        "samples": data.size,
    }


def _distribution(error: np.ndarray) -> dict[str, list[float]]:
    """The share of samples whose error is larger, at the errors of evenly spaced shares (log scale)."""
    shares = np.geomspace(1, 1 / error.size, 60)
    return {"share": shares.tolist(), "error": np.quantile(np.abs(error), 1 - shares).tolist()}


def groups(data: Labelled) -> dict[str, np.ndarray]:
    """zeta, kappa and the group p, as the share F_P/F_0 = p/sqrt(p^2 + kappa), and u."""
    rig, impact = data.rig, data.impact
    undamped = np.sqrt(impact.f_p**2 + rig.k_c * rig.m * impact.v_e**2)
    return {
        "zeta": np.asarray(rig.zeta),
        "kappa": np.asarray(rig.k_c / rig.k),
        "share": np.asarray(impact.f_p) / undamped,
        "u": fold_distance(data),
    }


def _maps(error: np.ndarray, data: Labelled) -> list[dict[str, Any]]:
    """The largest error in each cell of a plane of two groups; None where no sample falls."""
    x = groups(data)
    maps = []
    for across, up in (("zeta", "u"), ("zeta", "kappa"), ("share", "zeta")):
        cells, edges = [], []
        for name in (across, up):
            low, high = float(x[name].min()), float(x[name].max())
            index = ((x[name] - low) / (high - low) * MAP_CELLS).astype(int).clip(0, MAP_CELLS - 1)
            cells.append(index)
            edges.append([low, high])
        largest = np.full((MAP_CELLS, MAP_CELLS), -1.0)
        np.maximum.at(largest, (cells[1], cells[0]), np.abs(error))
        rows = [[None if value < 0 else float(f"{value:.3g}") for value in row] for row in largest]
        maps.append({"across": across, "up": up, "range": edges, "largest": rows})
    return maps


def _worst(error: np.ndarray, data: Labelled, count: int = 10) -> list[dict[str, float]]:
    """The samples with the largest relative errors, worst first."""
    order = np.argsort(-np.abs(error), kind="stable")[:count]
    rig, impact = data.rig, data.impact
    columns = dict(zip(UNITS, (rig.m, rig.zeta, rig.k_f, rig.k_c, impact.v_e, impact.f_p), strict=True))
    columns |= {"u": fold_distance(data), "f_max": data.peak.f_max, "relative_error": error}
    return [{name: float(column[i]) for name, column in columns.items()} for i in order]


def table1(config: Config, surrogate: Surrogate) -> list[dict[str, Any]]:
    """The paper's Table 1 beside this model and this surrogate, for the rig in the configuration."""
    if config.table1 is None:
        return []
    rig = Rig(**config.table1.rig.model_dump())
    rows = []
    for v_e, paper, measured in TABLE1:
        impact = Impact(v_e=v_e, f_p=TABLE1_F_P)
        prediction = surrogate(rig, impact, outside="flag")
        rows.append(
            {
                "v_e": v_e,
                "measured": measured,
                "paper_model": paper,
                "model": float(find_peak(rig, impact).f_max),
                "surrogate": float(prediction.f_max),
                "bound": float(prediction.error_bound) if prediction.is_inside else None,
            }
        )
    return rows


def summary(metrics: dict[str, Any]) -> str:
    """The errors and Table 1 as text for a terminal."""
    lines = ["", "Relative error of the peak force on fresh samples (even density over the box)"]
    lines.append(
        f"{'features':>14} {'median':>9} {'p99':>9} {'p99.9':>9} {'max':>9} {'largest under-prediction':>26}"
    )
    for name, error in metrics["errors"].items():
        relative, newton = error["box"]["relative"], error["box"]["newton"]
        numbers = " ".join(f"{relative[key]:9.1e}" for key in ("median", "p99", "p99_9", "max"))
        under = f"{relative['largest_under_prediction']:.1e}, {newton['largest_under_prediction']:.1e} N"
        lines.append(f"{name:>14} {numbers} {under:>26}")
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
