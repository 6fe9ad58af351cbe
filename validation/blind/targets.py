"""What a trustworthy diagnosis has to reach on blind data."""

from typing import Any, NamedTuple

from validation.blind.summary import counted


class Target(NamedTuple):
    """One line of the score: what was asked for and what came out."""

    name: str
    asked: str
    limit: float  # the same as a number
    reached: str
    met: bool | None  # None: too few cases to tell


LEAST = 5  # cases that show a target met: of four, all right, a method right every other time is within the interval


def targets(score: dict[str, Any]) -> list[Target]:
    """The targets in the order of the score's table."""
    weak, ceiling = score["weak"]["first"], score["weak"]["ceiling"]
    calibration = score["calibration"]
    beyond = calibration["expected_error"] - calibration["by_chance_95"] if calibration else None
    relative = weak["share"] / ceiling if ceiling and weak["n"] else None
    return [
        _at_least("clear single effects in the credible set", score["clear"]["covered"], 0.98),
        _at_least(
            "clear single effects first, or in one class with the first", score["clear"]["first"], 0.97
        ),
        Target(
            "weak single effects first or in one class, over the ceiling",
            "at least 95 %",
            0.95,
            f"{relative:.0%} ({weak['right']}/{weak['n']}, ceiling {ceiling:.2f})"
            if relative is not None
            else "-",
            None if relative is None else _met(weak["n"], relative >= 0.95),
        ),
        _at_least("pairs with both effects in the first explanation", score["pair"]["both_first"], 0.75),
        _at_least("pairs with at least one of them first", score["pair"]["one_first"], 0.97),
        _at_most("false alarms without any effect", score["none"]["false_alarms"], 0.05),
        _at_least("unknown causes recalled", score["unknown"]["recalled"], 0.90),
        _at_least("unknown causes at the right component", score["unknown"]["component"], 0.80),
        Target(
            "expected calibration error beyond chance",
            "at most 0.05",
            0.05,
            f"{beyond:+.3f} ({calibration['expected_error']:.3f}, chance {calibration['by_chance_95']:.3f})"
            if beyond is not None
            else "-",
            None if beyond is None else _met(sum(b["n"] for b in calibration["bins"]), beyond <= 0.05),
        ),
        _inside("real shrinkage inside the claimed interval", score["shrinkage"]),
        _inside("what no law explains inside the claimed interval", score["contributions"]),
        _at_least("predicted peaks inside their stated interval", score["predicted_peaks"], 0.90),
        _at_least("lifelike rigs right", score["lifelike"]["right"], 0.75),
        _at_most("lifelike rigs identified and wrong", score["lifelike"]["identified_wrong"], 0.03),
        _at_least("lifelike rigs with a foreign cause unknown", score["lifelike"]["unknown"], 0.85),
    ]


def _inside(name: str, claimed: dict[str, Any] | None) -> Target:
    return _at_least(name, claimed["inside"] if claimed else counted(0, 0), 0.90)


def _at_least(name: str, share: dict[str, Any], asked: float) -> Target:
    return Target(
        name,
        f"at least {asked:.0%}",
        asked,
        shown(share),
        _met(share["n"], share["n"] > 0 and share["share"] >= asked),
    )


def _at_most(name: str, share: dict[str, Any], asked: float) -> Target:
    return Target(
        name,
        f"at most {asked:.0%}",
        asked,
        shown(share),
        _met(share["n"], share["n"] > 0 and share["share"] <= asked),
    )


def _met(cases: int, holds: bool) -> bool | None:
    """Whether a target is met; a few cases may miss it, but not show that it is met."""
    return None if not cases or (holds and cases < LEAST) else holds


def shown(share: dict[str, Any]) -> str:
    """A share with its interval, in words."""
    if not share["n"]:
        return "-"
    low, high = share["ci95"]
    return f"{share['share']:.1%} ({share['right']}/{share['n']}; 95 %: {low:.0%} to {high:.0%})"
