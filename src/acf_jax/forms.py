"""The content of a file in the form of a pydantic model, or all that is wrong with it, in plain words."""

import json
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, TypeVar, get_args

from pydantic import BaseModel, ConfigDict, ValidationError

from acf_jax.errors import InputError, shown, suggestion

_SHOWN = 5  # faults of a file that a program wrote: it is to be made again, not mended
_COUNTED = 1000  # faults beyond which no one reads what each is

Form = TypeVar("Form", bound=BaseModel)


class Part(BaseModel):
    """A part of a file: it does not change, and refuses keys that it does not know and numbers that are not finite."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


def check_form(form: type[Form], content: Any, where: Path | str, remedy: str = "") -> Form:
    """`content` in its form; `InputError` lists every fault as `where: dotted.key: what is wrong; remedy`.

    **Arguments:** `remedy`: the one for all faults of a file that a program wrote.
    """
    try:
        return validated(form, content)
    except RecursionError:
        raise InputError(f"{where}: is nested too deeply; {remedy or 'correct it'}") from None
    except ValidationError as error:
        if error.error_count() > _COUNTED:
            what = f"{error.error_count():,} values do not fit the file's form"
            raise InputError(f"{where}: {what}; {remedy or 'write it anew'}") from None
        found = list(problems(form, content, error, remedy))
    faults = [f"{where}: {key}: {problem}" if key else f"{where}: {problem}" for key, problem in found]
    raise InputError(faults[:_SHOWN] if remedy else faults)


def validated(form: type[Form], content: Any) -> Form:
    """`content` in its form, or pydantic's `ValidationError`.

    Types are those of JSON, whatever the file: neither true nor quoted digits are a number, a list stands for a tuple.
    """
    return form.model_validate_json(json.dumps(content), strict=True)


def problems(
    form: type[BaseModel], content: Any, error: ValidationError, remedy: str = ""
) -> Iterator[tuple[str, str]]:
    """Each dotted key of `content` that does not fit its form, and what is wrong there with the remedy."""
    for fault in error.errors(include_url=False):
        keys = _keys(content, fault["loc"], fault["type"])
        what, own = _in_words(dict(fault), keys, form)
        for line in what.split("\n"):
            yield ".".join(keys), "; ".join(filter(None, (line, remedy or own)))


def _keys(content: Any, location: tuple[int | str, ...], kind: str) -> list[str]:
    """The keys that lead to a place, without the tags that pydantic puts between them for the members of a union."""
    keys = []
    for part in location:
        try:
            content = content[part]
        except (LookupError, TypeError):
            if kind != "missing" or part != location[-1]:
                continue
        keys.append(str(part))
    return keys


def _in_words(fault: Mapping[str, Any], keys: list[str], form: type[BaseModel]) -> tuple[str, str]:
    """What is wrong with a value, and the remedy; a validator of ours says both by itself."""
    kind = fault["type"]
    given = "empty" if fault["input"] is None else shown(fault["input"])
    if kind == "value_error":
        return str(fault["ctx"]["error"]), ""
    if kind == "missing":
        return "is missing", "add it"
    if kind in ("extra_forbidden", "invalid_key"):
        hint = suggestion(keys[-1], _known(form, keys[:-1])) if keys else ""
        return "is not a known key", hint.removeprefix("; ") or "remove it"
    if kind == "literal_error" and keys == ["schema"]:
        remedy = "correct it, or use the version of acf-jax that knows this schema"
        return f"must be {fault['ctx']['expected']}, but is {given}", remedy
    if kind in ("model_type", "model_attributes_type", "dict_type"):
        return f"must hold `key: value` pairs, but is {given}", "write them below it"
    if kind == "string_type":
        return f"must be text, but is {given}", "put it in quotes"
    if kind == "float_type":
        return f"must be a number, but is {given}", "write digits, such as 3.4e5"
    if kind in ("int_type", "int_from_float"):
        return f"must be a whole number, but is {given}", "write digits, such as 1000"
    if kind == "bool_type":
        return f"must be true or false, but is {given}", "write one of the two"
    what = re.sub(r"^\w+ should ", "must ", fault["msg"].split(", unable")[0])
    return f"{what[0].lower()}{what[1:]}, but is {given}", "correct the value"


def _known(form: type[BaseModel], keys: list[str]) -> list[str]:
    """The keys that a form knows at a place; a number in a list, or a name of the user's, leads no deeper."""
    models = [form]
    for key in keys:
        within = [m.model_fields[key].annotation for m in models if key in m.model_fields]
        models = [inner for annotation in within for inner in _models(annotation)] or models
    return [field.alias or name for model in models for name, field in model.model_fields.items()]


def _models(annotation: Any) -> Iterator[type[BaseModel]]:
    """The models in an annotation: itself, a union's members, the items of a tuple, the values of a mapping."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        yield annotation
    for inner in get_args(annotation):
        yield from _models(inner)
