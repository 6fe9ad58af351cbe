"""A diagnosis in words."""

from acf_jax.diagnosis.diagnose import Diagnosis
from acf_jax.diagnosis.score import UNKNOWN
from acf_jax.diagnosis.space import Explanation, label


def name_of(explanation: Explanation) -> str:
    """An explanation as a person says it."""
    return "a cause outside the library" if explanation == UNKNOWN else label(explanation)


def sentence(diagnosis: Diagnosis) -> str:
    """The verdict in one sentence."""
    d = diagnosis
    first = d.scored[0]
    percent = f"{100 * first.probability:.0f} %"
    shrunk = ""
    if d.shrinkage_force is not None:
        shrunk = f" It removes {100 * d.shrinkage_force.value:.0f} % of the force error on conditions the fit did not see."
    component = max(d.component, key=lambda c: d.component[c])
    match d.verdict:
        case "no_gap":
            return "No gap: parameter error and noise explain all that these trials show."
        case "identified":
            return f"Identified: {name_of(first.explanation)} ({percent}), at the {component}.{shrunk}"
        case "ambiguous":
            names = ", ".join(name_of(e) for e in d.credible)
            return f"Ambiguous: these trials leave {len(d.credible)} explanations standing ({names})."
        case "unknown":
            return f"Unknown: nothing in the library explains the gap ({percent}); it acts at the {component}.{shrunk}"
        case _:
            return "Insufficient data: these trials could not have told what causes the gap."
