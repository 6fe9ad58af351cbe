"""What is read back in a blind run: answers and diagnoses, checked before they are scored."""

from pathlib import Path
from typing import Any

from pydantic import BaseModel, ConfigDict, Field, FiniteFloat, field_validator

from acf_jax.diagnosis.contributions import BACKGROUND, SCATTER
from acf_jax.effects import Component, library
from acf_jax.errors import InputError, shown
from acf_jax.files import read_json_mapping, read_text, read_yaml_mapping
from acf_jax.forms import check_form

ANSWER, DIAGNOSIS, SECONDS = "answer.yaml", "diagnosis.json", "seconds.txt"


class _Part(BaseModel):
    model_config = ConfigDict(frozen=True, extra="ignore")


class Mode(_Part):
    """A mode of the sensor, as its world drew it."""

    damping_ratio: FiniteFloat | None = None


class Parameters(_Part):
    """Of the causes, those that a score reads."""

    sensor_resonance: Mode | None = None


class Answer(_Part):
    """The cause of one data set; everything but `effects` may be left out.

    `background` holds the small effects of a lifelike rig, with the share of the force that each changes: they are in
    the rig, but need not be named.
    """

    effects: tuple[str, ...]
    background: dict[str, FiniteFloat] = {}
    parameters: Parameters = Parameters()
    components: tuple[Component, ...] = ()
    outside_library: bool = False
    withheld: str = ""
    world: str = ""
    whitened_distance: FiniteFloat | None = None
    ceiling: FiniteFloat | None = None
    neighbours: dict[str, FiniteFloat] = {}
    rig: dict[str, FiniteFloat] = {}
    faulty_trials: dict[str, Any] = {}


class Explanation(_Part):
    """What a diagnosis names, and how sure it is."""

    effects: tuple[str, ...]
    probability: float = Field(ge=0, le=1)


class Class(_Part):
    """What trials could not separate."""

    effects: tuple[str, ...]


class Where(_Part):
    """Probability that a cause acts at each component."""

    component: dict[str, FiniteFloat] = Field(min_length=1)


class Claim(_Part):
    """A claimed shrinkage with its 95 % interval."""

    value: FiniteFloat
    ci95: tuple[FiniteFloat, FiniteFloat]


class Shrinkage(_Part):
    """Of the force; null where there is none."""

    force: Claim | None


class Contribution(_Part):
    """A part of the gap: an effect's, or what no law explains (`background`), or what repeats do not share."""

    effect: str
    force_share: Claim


class Parameter(_Part):
    """A fitted parameter."""

    value: FiniteFloat | None
    std: FiniteFloat | None


class Excluded(_Part):
    """A trial that was not used."""

    trial: str


class Said(_Part):
    """What a score reads of a diagnosis.json."""

    verdict: str
    explanations: tuple[Explanation, ...] = Field(min_length=1)
    credible_set: tuple[tuple[str, ...], ...]
    indistinguishable: tuple[Class, ...]
    where: Where
    shrinkage: Shrinkage
    contributions: tuple[Contribution, ...] | None = None
    parameters: dict[str, Parameter]
    excluded_trials: tuple[Excluded, ...]

    @field_validator("contributions")
    @classmethod
    def _are_whole(cls, parts: tuple[Contribution, ...] | None) -> tuple[Contribution, ...] | None:
        """What no law explains and what scatters belongs to every gap that is shared out."""
        missing = [
            name for name in (BACKGROUND, SCATTER) if name not in {part.effect for part in parts or ()}
        ]
        if parts and missing:
            raise ValueError(f"has no part called {' nor '.join(missing)}")
        return parts


class Failed(_Part):
    """A data set that could not be diagnosed is a result as well."""

    error: str


def read_answer(folder: Path) -> Answer:
    """The answer beside a data set."""
    path = folder / ANSWER
    return check_answer(path, read_yaml_mapping(path))


def check_answer(where: Path | str, content: Any) -> Answer:
    """An answer from its keys; `InputError` names those that are wrong, and effects that may be misspelt."""
    remedy = "write effects: [...], with components: [...] for an unknown one"
    answer = check_form(Answer, content, where, remedy)
    for key, names in (("effects", answer.effects), ("background", tuple(answer.background))):
        strange = [name for name in names if name not in library()]
        if strange and not answer.components:
            raise InputError(
                f"{where}: {key}: {shown(strange[0])} is none of {', '.join(library())};"
                " for a cause outside the library write components: [...] as well"
            )
    mode = answer.parameters.sensor_resonance
    if mode and mode.damping_ratio is not None and mode.damping_ratio >= 1:
        return _as_lag(answer)
    return answer


def _as_lag(answer: Answer) -> Answer:
    """A mode of the sensor that is damped beyond ringing is a low-pass: the library calls it a lag."""

    def renamed(name: str) -> str:
        return "sensor_lag" if name == "sensor_resonance" else name

    effects = tuple(dict.fromkeys(map(renamed, answer.effects)))
    small = {renamed(name): share for name, share in answer.background.items()}
    background = {name: share for name, share in small.items() if name not in effects}
    return answer.model_copy(update={"effects": effects, "background": background})


def read_said(result: Path) -> Said | Failed:
    """What was said of a data set; `InputError` where the file is damaged."""
    path, remedy = result / DIAGNOSIS, "remove its folder, and diagnose again"
    content = read_json_mapping(path, remedy)
    if "error" in content:
        return check_form(Failed, content, path, remedy)
    return check_form(Said, content, path, remedy)


def read_seconds(result: Path) -> float | None:
    """How long a diagnosis took, s, as its folder says; None where it does not."""
    path = result / SECONDS
    try:
        return float(read_text(path)) if path.exists() else None
    except ValueError:
        return None
