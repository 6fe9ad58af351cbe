"""What is known of each measured set, frozen before the first diagnosis, and what an answer counts as."""

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from acf_jax.documents import parse_yaml
from acf_jax.effects import library
from acf_jax.errors import InputError

HERE = Path(__file__).parent
OUTCOMES = ("right", "wrong", "undecided", "unknown", "insufficient data")
EVERYWHERE = "gravity"  # an effect that no rig lacks


@dataclass(frozen=True)
class Answer:
    """What is known of one set, and what counts as right."""

    known: str
    right: Mapping[str, Any]
    absent: Sequence[str] = ()
    injected: bool = False

    @property
    def without(self) -> list[str]:
        """Components and effects that the rig does not have; `EVERYWHERE` acts on one without its component, too."""
        kept = library()[EVERYWHERE].component
        laws = [name for name, law in library().items() if law.component == kept and name != EVERYWHERE]
        return [name for component in self.absent for name in (laws if component == kept else [component])]


def read_answers(folder: Path = HERE) -> dict[str, Answer]:
    """The frozen answers; `InputError` where the file is not the one that was frozen."""
    path = folder / "answers.yaml"
    digest = hashlib.sha256(path.read_bytes()).hexdigest()
    if digest != (folder / "answers.sha256").read_text("utf-8").split()[0]:
        raise InputError([f"{path} is not the file that was frozen before the first diagnosis; restore it"])
    return {
        name: Answer(**entry) for name, entry in parse_yaml(path.read_text("utf-8"), path)["sets"].items()
    }


def outcome(answer: Answer, diagnosis: Mapping[str, Any]) -> str:
    """One of `OUTCOMES` for a `diagnosis.json`.

    'wrong' is a name that is not right, 'undecided' an ambiguous answer that holds a right one but not first.
    """
    right, verdict = answer.right, diagnosis["verdict"]
    if "excluded" in right:
        left_out = {entry["trial"] for entry in diagnosis["excluded_trials"]}
        return "right" if left_out == set(right["excluded"]) else "wrong" if left_out else "unknown"
    if verdict == "insufficient_data":
        return "insufficient data"
    if verdict == "unknown":
        component = diagnosis["where"]["component"]
        here = "component" in right and max(component, key=component.get) == right["component"]
        return "right" if here else "unknown"
    if "verdict" in right:
        return "right" if verdict == right["verdict"] else "wrong"
    if is_right(answer, diagnosis["explanations"][0]["effects"]):
        return "right"
    held = any(is_right(answer, effects) for effects in diagnosis["credible_set"])
    return "undecided" if verdict == "ambiguous" and held else "wrong"


def is_right(answer: Answer, effects: Sequence[str]) -> bool:
    """Whether an explanation is the known cause, at whichever component an unknown one lies."""
    if list(effects) == ["unknown"]:
        return "component" in answer.right
    if "verdict" in answer.right:
        return not effects and answer.right["verdict"] == "no_gap"
    named = set(effects) & set(answer.right.get("effects", ()))
    missing = {e for e in effects if e != EVERYWHERE and library()[e].component in answer.absent}
    return bool(named) and not missing
