"""YAML and JSON as every file of the project is read: the one place that says what a number is.

YAML is read as its version 1.2 means it: numbers are decimal digits (010 is ten), keys are text, and true, false and
null are the only words that are no text. What only version 1.1 knows, such as 1:30, 0x1F, yes or a date, is text.
"""

import json
import math
import re
import sys
from collections import Counter
from collections.abc import Iterator
from itertools import takewhile
from typing import Any

import yaml

from acf_jax.errors import InputError, shown

MOST_BYTES = {"YAML": 5_000_000, "JSON": 20_000_000}  # a hundred times what the largest files of a run hold
MOST_VALUES = {"YAML": 250_000, "JSON": 1_000_000}  # each takes up to a hundred bytes of memory
DEEPEST = 40  # levels of lists and mappings
LONGEST_NUMBER = 400  # digits; the largest float64 has 309

_NUMBER = re.compile(
    r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?|[-+]?\.(inf|Inf|INF)|\.(nan|NaN|NAN)"
)
_WORDS: dict[str, bool | None] = {
    **dict.fromkeys(("true", "True", "TRUE"), True),
    **dict.fromkeys(("false", "False", "FALSE"), False),
    **dict.fromkeys(("null", "Null", "NULL", "~", ""), None),
}
_Loader: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)  # libyaml's is six times faster


class _Fault(ValueError):
    """What is wrong with a document, and in which line, counted from 0."""

    def __init__(self, what: str, line: int | None = None):
        super().__init__(what)
        self.what, self.line = what, line


def parse_yaml(text: str, where: object) -> Any:
    """The value of a YAML document; `InputError`, which begins with `where`, for what is none.

    Refused besides: a key given twice, aliases and tags, which a configuration does not need and which can stand for
    more than they hold; a number that no float64 holds; a document beyond the limits of this module.
    """
    try:
        _check_size(text, "YAML")
        events: Iterator[Any] = iter(yaml.parse(text, Loader=_Loader))
        next(events)  # the stream's begin
        if isinstance(next(events), yaml.StreamEndEvent):
            return None
        value = _Builder(events).value(next(events))
        next(events)  # the document's end
        if not isinstance(after := next(events), yaml.StreamEndEvent):
            raise _Fault("a second document begins here", after.start_mark.line)
        return value
    except _Fault as fault:
        what, line = fault.what, fault.line
    except yaml.YAMLError as error:
        mark = getattr(error, "problem_mark", None)
        what, line = getattr(error, "problem", None) or "not valid YAML", mark.line if mark else None
    except UnicodeEncodeError:
        what, line = "half a character", None
    raise InputError(f"{where}{'' if line is None else f' line {line + 1}'}: {what}; correct the YAML")


def parse_json(text: str, where: object, remedy: str) -> Any:
    """The value of a JSON document; `InputError`, which begins with `where` and ends with `remedy`, for what is none.

    Refused besides: a key given twice; NaN, infinity and what no float64 holds; a document beyond the limits above.
    """
    try:
        _check_size(text, "JSON")
        if text.count(",") > MOST_VALUES["JSON"]:
            raise _Fault(f"holds more than {MOST_VALUES['JSON']:,} values")
        value = json.loads(
            text, parse_int=_number, parse_float=_number, parse_constant=_no_number, object_pairs_hook=_object
        )
        if not _is_flat(value, DEEPEST):
            raise _Fault("is nested too deeply")
        if "\\u" in text:
            json.dumps(value, ensure_ascii=False).encode()
        return value
    except _Fault as fault:
        what = fault.what
    except RecursionError:
        what = "is nested too deeply"
    except UnicodeEncodeError:
        what = "holds half a character"
    except ValueError as error:
        what = f"is not JSON ({error})"
    raise InputError(f"{where}: {what}; {remedy}")


def yaml_text(value: Any) -> str:
    """A YAML document that `parse_yaml` reads back as `value`."""
    return yaml.dump(value, Dumper=_Dumper, sort_keys=False, width=10_000)


def is_number(value: Any) -> bool:
    """Whether a value is a finite number: true and false are none."""
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) <= sys.float_info.max


class _Builder:
    """Makes values of a YAML parser's events."""

    count = 0  # values so far

    def __init__(self, events: Iterator[Any]):
        self.events = events

    def value(self, event: Any, depth: int = 0) -> Any:
        """The value that begins with an event."""
        line: int = event.start_mark.line
        self.count += 1
        if self.count > MOST_VALUES["YAML"]:
            raise _Fault(f"more than {MOST_VALUES['YAML']:,} values", line)
        if depth > DEEPEST:
            raise _Fault("nested too deeply", line)
        if isinstance(event, yaml.AliasEvent):
            raise _Fault("aliases (*name) are not known; write values out", line)
        if event.tag is not None:
            raise _Fault(f"tags ({shown(event.tag)}) are not known; write the value without", line)
        if isinstance(event, yaml.ScalarEvent):
            return event.value if event.style else _plain(event.value, line)
        if isinstance(event, yaml.SequenceStartEvent):
            return [self.value(e, depth + 1) for e in self._until(yaml.SequenceEndEvent)]
        found: dict[str, Any] = {}
        for key in self._until(yaml.MappingEndEvent):
            line = key.start_mark.line
            if not isinstance(key, yaml.ScalarEvent) or key.tag is not None:
                raise _Fault("a key must be text", line)
            if key.value in found:
                raise _Fault(f"key {shown(key.value)} is given twice", line)
            found[key.value] = self.value(next(self.events), depth + 1)
        return found

    def _until(self, end: type) -> Iterator[Any]:
        """The events that begin the items of a list or a mapping, whose end is taken as well."""
        return takewhile(lambda event: not isinstance(event, end), self.events)


def _plain(text: str, line: int) -> Any:
    """The value of a scalar without quotes."""
    if text in _WORDS:
        return _WORDS[text]
    if not _NUMBER.fullmatch(text):
        return text
    if text.lower().lstrip("+-") in (".inf", ".nan"):
        return float(text.lower().replace(".", ""))
    try:
        return _number(text)
    except _Fault as fault:
        raise _Fault(fault.what, line) from None


def _number(text: str) -> float:
    """An integer or a float, in decimal digits."""
    value = float(text)
    if math.isinf(value) or len(text) > LONGEST_NUMBER:
        raise _Fault(f"{shown(text)} is larger, or longer, than any number that can be computed with")
    return int(text) if text.lstrip("+-").isdigit() else value


def _no_number(text: str) -> Any:
    raise _Fault(f"holds {text}, which is no number")


def _object(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    found = dict(pairs)
    if len(found) < len(pairs):
        twice = next(name for name, n in Counter(name for name, _ in pairs).items() if n > 1)
        raise _Fault(f"key {shown(twice)} is given twice")
    return found


def _is_flat(value: Any, levels: int) -> bool:
    """Whether lists and mappings are nested in so many levels at most."""
    inner = value.values() if isinstance(value, dict) else value if isinstance(value, list) else ()
    return not inner or (levels > 0 and all(_is_flat(v, levels - 1) for v in inner))


def _check_size(text: str, form: str) -> None:
    if len(text) > MOST_BYTES[form]:
        raise _Fault(f"is larger than the {MOST_BYTES[form] // 10**6} MB that a {form} file may have")


class _Dumper(yaml.SafeDumper):
    """Quotes text that would be read back as a number, and writes values out each time."""

    def ignore_aliases(self, data: Any) -> bool:
        return True


_Dumper.add_implicit_resolver("tag:yaml.org,2002:float", _NUMBER, list("-+.0123456789"))
