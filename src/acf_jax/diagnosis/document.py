"""`diagnosis.json`: the diagnosis as the contract says, plain JSON."""

from typing import Any

import numpy as np

from acf_jax.diagnosis.contributions import Contribution
from acf_jax.diagnosis.diagnose import Diagnosis
from acf_jax.diagnosis.shrinkage import Shrinkage
from acf_jax.evidence.posterior import UNKNOWN
from acf_jax.inference.fit import Fit
from acf_jax.inference.parameters import Explanation, parameters
from acf_jax.provenance import PROGRAM

SCHEMA = "acf-gap-diagnosis/1"
LISTED = 1e-4  # explanations below this probability are not listed one by one


def document(diagnosis: Diagnosis) -> dict[str, Any]:
    """The content of `diagnosis.json`."""
    d = diagnosis
    return {
        "schema": SCHEMA,
        "verdict": d.verdict,
        "explanations": _explanations(d),
        "credible_set": [list(e) for e in d.credible],
        "indistinguishable": [
            {"effects": _union(p.effects), "bayes_error": _round(p.bayes_error)} for p in d.indistinguishable
        ],
        "where": {
            "component": {name: _round(p) for name, p in d.component.items()},
            "phase": {name: _round(share) for name, share in d.gap_map.phase.items()},
            "conditions": [
                {
                    "contact_velocity_m_per_s": c.v_e,
                    "pretension_n": c.f_p,
                    "excess_rms_n": _round(c.excess_rms_n),
                    "share": _round(c.share),
                    "contributions_rms_n": {
                        part.name: _round(part.of_condition[k]) for part in d.contributions
                    },
                }
                for k, c in enumerate(d.gap_map.conditions)
            ],
        },
        "gap": {
            **{
                name: {
                    "force_rms_n": _round(g.force_rms_n),
                    "peak_rms_percent": _round(g.peak_rms_percent),
                    "peak_max_percent": _round(g.peak_max_percent),
                }
                for name, g in d.gap.items()
            },
            "noise_floor_rms_n": _round(d.noise_floor_rms_n),
        },
        "corrected_is_better": None if d.comparison is None else d.comparison.is_better,
        "shrinkage": {"force": _shrinkage(d.shrinkage_force), "peak": _shrinkage(d.shrinkage_peak)},
        "contributions": [_contribution(c) for c in d.contributions] or None,
        "parameters": fitted_parameters(d.corrected),
        "absorbed": {x.effect: _round(x.absorbed) for x in d.detectability},
        "next_experiment": _experiment(d),
        "evidence": [
            {
                "effects": list(m.explanation),
                "discrepancy": m.discrepancy,
                "objective": _round(m.objective, 9),
                "log_occam": _round(m.log_occam, 7),
                "force_changes_n": [_round(value) for value in m.changes],
                "log_likelihood_of_conditions": [_round(value, 7) for value in m.of_conditions],
            }
            for m in d.evidence
        ],
        "excluded_trials": [{"trial": name, "reason": reason} for name, reason in d.excluded.items()],
        "warnings": list(d.warnings),
        "made_by": PROGRAM,
        "data_sha256": d.dataset.digest,
    }


def fitted_parameters(fitted: Fit) -> dict[str, Any]:
    """Value, standard deviation and unit of each physical parameter."""
    std = np.sqrt(np.diag(fitted.covariance))
    return {
        name: {
            "value": _round(value, 8),
            "std": _round(s, 6),
            "unit": p.unit,
            "at_bound": bool(bound),
            "meaning": p.meaning,
        }
        for (name, p), value, s, bound in zip(
            parameters(fitted.explanation), fitted.theta, std, fitted.at_bound, strict=False
        )
    }


def _explanations(d: Diagnosis) -> list[dict[str, Any]]:
    always = [(), UNKNOWN]
    listed = [s for s in d.scored if s.probability >= LISTED or s.explanation in always]
    total = sum(s.probability for s in listed)
    return [{"effects": list(s.explanation), "probability": s.probability / total} for s in listed]


def _union(effects: tuple[Explanation, Explanation]) -> list[str]:
    return sorted(set(effects[0]) | set(effects[1]))


def _shrinkage(s: Shrinkage | None) -> dict[str, Any] | None:
    if s is None or not np.isfinite([s.value, *s.ci95]).all():
        return None
    return {"value": _round(s.value), "ci95": [_round(s.ci95[0]), _round(s.ci95[1])]}


def _contribution(c: Contribution) -> dict[str, Any]:
    return {
        "effect": c.name,
        **({} if c.component is None else {"component": {n: _round(p) for n, p in c.component.items()}}),
        "force_share": {"value": _round(c.share), "ci95": [_round(c.ci95[0]), _round(c.ci95[1])]},
        "force_rms_n": _round(c.force_rms_n),
        "peak_n": _round(c.peak_n),
    }


def _experiment(d: Diagnosis) -> dict[str, Any] | None:
    e = d.next_experiment
    if e is None:
        return None
    return {
        "contact_velocity_m_per_s": _round(e.v_e),
        "pretension_n": _round(e.f_p),
        "repeats": e.repeats,
        "separates": [list(effects) for effects in e.separates],
        "probability_of_error_before": _round(e.error_before),
        "probability_of_error_after": _round(e.error_after),
    }


def _round(value: float | None, digits: int = 5) -> float | None:
    """`digits` significant figures; None for what does not exist or is not finite."""
    if value is None or not np.isfinite(value):
        return None
    return float(f"{float(value):.{digits}g}")
