"""What a cell of text holds: a number, a date or time of day, or a word that there is no value."""

import re
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

# As pandas reads them, the dashes of German tables, and what C writes on Windows.
_NO_VALUE = "- -- --- . ? na n/a n.a. nan -nan nat <na> null none missing 1.#ind -1.#ind 1.#qnan -1.#qnan"
_MISSING = frozenset(_NO_VALUE.split())
_ERROR = re.compile(
    r"#[¡¿]?(?:\w/\w!?|nv|[^\W\d_]+(?:/0)?[!?])(?: .*)?"
)  # of a sheet: #N/A, #NV, #DIV/0!, #WERT!

_MONTHS = ("jan", "feb", "mar", "apr", "may", "jun", "jul", "aug", "sep", "oct", "nov", "dec")
_MONTH = "|".join(_MONTHS)
_HALF = r"[ap]\.?m\.?"
# What is meant for a date or a time of day, whether or not it is understood.
_DAY = rf"\d{{1,4}}[-/.]\d{{1,2}}[-/.]\d{{1,4}}|\d{{1,2}}[- ](?:{_MONTH})[- ]\d{{2,4}}"
_CLOCK = rf"\d{{1,2}}:\d\d(?:[:.,]\d+){{0,2}}\s*(?:{_HALF})?\s*(?:z|utc|gmt|[+-]\d\d:?\d{{0,2}})?"
_LIKE = re.compile(rf"(?:{_DAY})(?:(?:t|[ ,]\s*){_CLOCK})?|{_CLOCK}", re.IGNORECASE)
# What means one thing only. 3/1/2026 does not: it is in March, or in January.
_STAMP = re.compile(
    r"(?:(?:(?P<year>\d{4})([-/.])(?P<month>\d\d?)\2(?P<day>\d\d?)"
    rf"|(?P<D>\d\d?)(?:\.(?P<M>\d\d?)\.|[- ](?P<named>{_MONTH})[- ])(?P<Y>\d{{4}}))(?:t|[ ,]\s*))?"
    r"(?:(?P<hour>\d\d?):(?P<minute>\d\d)(?::(?P<second>\d\d)(?:[.,:](?P<fraction>\d{1,9}))?)?"
    r"|(?P<minutes>\d\d?):(?P<seconds>\d\d)[.,](?P<rest>\d{1,9}))"
    rf"\s*(?P<half>{_HALF})?\s*(?:z|utc|gmt|(?P<zone>[+-]\d\d)(?::?(?P<past>\d\d))?)?",
    re.IGNORECASE,
)
STAMP_REMEDY = "write them as 2026-03-01T10:00:00.000, give seconds, or state --rate"


def is_number(cell: str) -> bool:
    """Whether a cell holds a number, with a decimal point or comma, or what is meant for a date or time of day."""
    try:
        float(cell.replace(",", "."))
    except ValueError:
        return is_stamp(cell)
    return True


def is_missing(cell: str) -> bool:
    """Whether a cell is blank or says that there is no value."""
    text = cell.strip().casefold()
    return not text or text in _MISSING or is_error(text)


def is_error(cell: str) -> bool:
    """Whether a cell is what a sheet shows in place of a value that it cannot compute."""
    return _ERROR.fullmatch(cell.strip().casefold()) is not None


def is_stamp(cell: str) -> bool:
    """Whether a cell looks like a date or a time of day."""
    return _LIKE.fullmatch(cell.strip()) is not None


def stamps(cells: Sequence[str]) -> NDArray[np.datetime64]:
    """Dates in UTC, ns; times of day are those of the first of January 1970, NaT where a value is missing.

    **Raises:** `ValueError` where a cell is neither, or may be two dates.
    """
    texts, ahead = [], np.zeros(len(cells), "timedelta64[m]")
    for i, cell in enumerate(cells):
        if is_missing(cell):
            texts.append("NaT")
            continue
        found = _STAMP.fullmatch(cell.strip())
        if found is None:
            raise ValueError("no date of one meaning")
        texts.append(f"{_date(found)}T{_time(found)}")
        if zone := found["zone"]:
            ahead[i] = int(zone) * 60 + int(zone[0] + (found["past"] or "00"))
    return np.array(texts, "datetime64[ns]") - ahead


def _date(found: re.Match[str]) -> str:
    if not (year := found["year"] or found["Y"]):
        return "1970-01-01"
    month = found["month"] or found["M"] or str(_MONTHS.index(found["named"].lower()) + 1)
    return f"{year}-{month:0>2}-{found['day'] or found['D']:0>2}"


def _time(found: re.Match[str]) -> str:
    if found["rest"]:
        return f"00:{found['minutes']:0>2}:{found['seconds']}.{found['rest']}"
    hour = int(found["hour"])
    if found["half"]:  # 12 am is midnight
        if not 1 <= hour <= 12:
            raise ValueError("no hour of a half of the day")
        hour = hour % 12 + (12 if found["half"][0] in "pP" else 0)
    return f"{hour:0>2}:{found['minute']}:{found['second'] or '00'}.{found['fraction'] or '0'}"
