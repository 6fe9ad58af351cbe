"""How long a job still takes, by the stages that it has been through."""

from collections.abc import Sequence

# Share of a diagnosis that each stage takes, in s of examples/session.mcap on two cores.
DIAGNOSE = {
    "looking at the data": 0.5,
    "recalibrating the paper's model": 0.5,
    "fitting every effect": 19.0,
    "searching for pairs": 1.0,
    "asking what the noise is like": 1.5,
    "weighing explanations": 7.0,
    "holding out one condition after the other": 1.0,
    "asking what these trials can tell apart": 6.0,
    "writing the report": 6.0,
}
_MOST = 0.95  # of a stage that is known to be done before it ends


def left_after(
    kind: str, stages: Sequence[tuple[str, float]], elapsed: float, done: int, total: int
) -> float | None:
    """Time left, s; None where nothing tells it.

    **Arguments:** `stages`: names and when they began, s. `elapsed`: since the start, s. `done`, `total`: of the last
    stage, where it counts.
    """
    if not stages:
        return None
    name, begun = stages[-1]
    if kind != "diagnose":
        return (elapsed - begun) * (total - done) / done if 0 < done <= total else None
    if name not in DIAGNOSE:
        return None
    names = list(DIAGNOSE)
    before = sum(DIAGNOSE[other] for other in names[: names.index(name)])
    whole = sum(DIAGNOSE.values())
    # what the stages before took says how fast this machine is, and how large the data set
    pace = begun / before if before > 1.0 else 1.0
    within = min((elapsed - begun) / (pace * DIAGNOSE[name]), _MOST) * DIAGNOSE[name]
    return max(whole - before - within, 0.0) * pace
