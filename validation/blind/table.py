"""The score as text."""

from collections.abc import Sequence
from typing import Any

from validation.blind.summary import Row
from validation.blind.targets import targets


def lines(rows: Sequence[Row], score: dict[str, Any]) -> str:
    """One line a data set, then the figures."""
    text = [_line(r) for r in rows]
    text.append("")
    width = max(len(t.name) for t in targets(score))
    for t in targets(score):
        mark = {True: "met ", False: "MISS", None: "    "}[t.met]
        text.append(f"{mark} {t.name:<{width}}  {t.asked:<14}  {t.reached}")
    text.append(
        f"     first answers that are right: {_of(score['first'])}; without classes {_of(score['first_strict'])}"
    )
    strict = score["clear"]["first_strict"], score["unknown"]["recalled_strict"]
    text.append(
        f"     without classes: clear single effects first {_of(strict[0])}, unknown causes {_of(strict[1])};"
        f" with them: pairs {_of(score['pair']['both_first_in_class'])}"
    )
    text.append(f"     no_gap without any effect {_of(score['none']['no_gap'])}")
    if (lifelike := score["lifelike"])["right"]["n"]:
        text += [f"     {name} {_of(share)}" for name, share in lifelike_figures(lifelike)]
    if shrinkage := score["shrinkage"]:
        text.append(
            "     held-out force error, corrected over recalibrated:"
            f" median {shrinkage['median_ratio']:.3f}, worst {shrinkage['worst_ratio']:.3f};"
            f" median width of the claimed interval {shrinkage['median_width']:.2f}"
        )
    text.append(f"     rig constants within two stated deviations {_of(score['rig_within_2_sigma'])}")
    if seconds := score["seconds"]:
        text.append(f"     time a data set: median {seconds['median']:.0f} s, most {seconds['most']:.0f} s")
    if score["errors"]:
        text.append(f"     not usable: {', '.join(score['errors'])}")
    return "\n".join(text) + "\n"


def lifelike_figures(score: dict[str, Any]) -> list[tuple[str, dict[str, Any]]]:
    """What came out of lifelike rigs: a name and a share each."""
    figures = [
        (
            "lifelike rigs: every large effect named and none that is not in the rig, foreign causes unknown",
            score["right"],
        ),
        ("the same, where effects of one class count", score["right_in_class"]),
        ("lifelike rigs without a foreign cause", score["named"]),
        ("lifelike rigs with a foreign cause, as unknown", score["unknown"]),
    ]
    if score["shrinkage"]:
        figures.append(
            ("lifelike rigs: real shrinkage inside the claimed interval", score["shrinkage"]["inside"])
        )
    return figures


def _of(share: dict[str, Any]) -> str:
    return f"{share['right']}/{share['n']}"


def _line(row: Row) -> str:
    truth = cause_of(row)
    distance = f" d {row['distance']:.1f}" if row["distance"] is not None and row["kind"] != "none" else ""
    if "error" in row:
        return f"{row['set']} error {row['error']}"
    real = f", real shrinkage {1 - row['ratio']:.2f}" if row["kind"] != "none" and "ratio" in row else ""
    return (
        f"{row['set']} {mark(row)} {row['verdict']:<17} {truth}{distance}:"
        f" {named(row['first'])} {row['probability_first']:.2f}{real}"
    )


def mark(row: Row) -> str:
    """How good an answer was, in one word."""
    if "error" in row:
        return "error"
    for key, word in (("first_right", "right"), ("first_in_class", "class"), ("covered", "cred.")):
        if row[key]:
            return word
    return "MISS "


def cause_of(row: Row) -> str:
    """What was true, in words."""
    if row["kind"] == "lifelike":
        return f"{named(row['causes'])} among {len(row['background'])} small"
    return named(row["causes"]) + (" (withheld)" if row["kind"] == "withheld" else "")


def named(effects: Sequence[str]) -> str:
    """Effects joined."""
    return "+".join(effects) or "none"
