"""What names of columns say: whether one is a time, in which unit, or a force, in the languages of usual headers."""

import re
import unicodedata
from collections.abc import Iterable

# What a column of times is called; a longer name may hold one of these as a word of its own or as a part.
_TIMES = """
    t time times timestamp timestamps stamp stamps clock  zeit zeiten zeitstempel  temps horodatage  tiempo  tempo
    tijd  tid  aika  czas  čas vrijeme vreme  idő  timp  zaman  время час  χρόνος  时间 時間 时刻 時刻 시간 시각
"""
_PARTS = r"times?|(?:time)?stamps?|zeit(?:en)?|tijd|时间|時間|时刻|時刻|시간"

# Of a role: words, of which a name holds one.
_ROLES = {
    "force": """force fz f_z load  kraft  fuerza  forza  forca forta  kracht  kraften  voima  sila  siła  kuvvet  erő
        сила  δύναμη  力 힘""",
    "velocity": """velocity speed  geschwindigkeit  vitesse viteza  velocidad velocita velocidade  snelheid  hastighet
        hastighed  nopeus  prędkość rychlost brzina  sebesség  hız  скорость  ταχύτητα  速度 속도""",
    "position": """position  posicion posizione posicao pozitie  positie  pozycja poloha  pozíció  konum
        позиция положение  θέση  位置 위치""",
    "pretension": """pretension preload  vorspannung vorspannkraft vorlast  precharge precontrainte  precarga pretensado
        precarico  voorspanning  forspanning forspænding  esijännitys  wstępne wstępny  předpětí  predpätie  előfeszítés
        önyük öngerilme  преднатяг преднагрузка  προφόρτιση  예압  预紧力 予圧""",
}

_SECONDS = {
    1.0: "s sec secs second seconds sek sekunde sekunden seconde secondes segundo segundos secondi с сек 秒 초",
    1e-3: "ms msec msecs milli millis millisecond milliseconds millisekunden мс 毫秒",
    1e-6: "us usec usecs µs micro micros microsecond microseconds mikrosekunden мкс 微秒",
    1e-9: "ns nsec nsecs nano nanos nanosec nanosecs nanosecond nanoseconds nanosekunden нс 纳秒",
}
_LONGER = {60.0: "min minuten minutes", 3600.0: "h std hours"}  # where brackets or a row of units say so


def fold(text: str) -> str:
    """`text` without case and accents."""
    parts = unicodedata.normalize("NFKD", text.casefold())
    return unicodedata.normalize("NFC", "".join(c for c in parts if not unicodedata.combining(c)))


def _words(text: str) -> list[str]:
    return [fold(word) for word in text.split()]


_TIME_WORDS = frozenset(_words(_TIMES))
_LIKE_TIME = re.compile(rf"(?:{_PARTS}).*|.*(?:{_PARTS})")
_UNITS = {word: scale for scale, words in _SECONDS.items() for word in _words(words)}
_ALL_UNITS = _UNITS | {word: scale for scale, words in _LONGER.items() for word in _words(words)}
_LAST = re.compile(rf"(?:^|[\W_])({'|'.join(map(re.escape, _UNITS))})[\W_]*$")
_IN_BRACKETS = re.compile(r"[\[({<]\s*([^\[\](){}<>]+?)\s*[\])}>]\s*$")
NUMBERED = re.compile(r" \(\d+\)$")  # behind columns of one name
_PATH = re.compile(r"/|(?<=\w)\.(?=\w)")
_ROLE = {
    role: re.compile(
        "|".join(
            re.escape(word) if ord(word[0]) > 0x2E80 else rf"(?<![^\W\d_]){re.escape(word)}(?![^\W\d_])"
            for word in _words(words)
        )
    )
    for role, words in _ROLES.items()
}
# Pre-load and pretension in two words are one.
_BEFOREHAND = re.compile(r"(?<![^\W\d_])(pre|vor|voor|for|on)[-_ ]+(?=[^\W\d_])")


def is_called(name: str, role: str) -> bool:
    """Whether a name holds a word for a force, velocity, position or pretension."""
    return _ROLE[role].search(_with_joined(name)) is not None


def is_signal(name: str) -> bool:
    """Whether a name holds a word for one of these."""
    text = _with_joined(name)
    return any(pattern.search(text) for pattern in _ROLE.values())


def _with_joined(name: str) -> str:
    """A name, folded, and once more where two words of it are one."""
    text = fold(name)
    joined = _BEFOREHAND.sub(r"\1", text)
    return text if joined == text else f"{text} {joined}"


def _apart(name: str) -> str:
    """Folded, timeMs as time ms, without the number that tells apart columns of one name."""
    return fold(re.sub(r"(?<=[a-z])(?=[A-Z])", " ", NUMBERED.sub("", name.strip())))


def unit_of(name: str) -> float | None:
    """Seconds in the unit of time that ends a name: `t_ms`, `Time [ms]`, `t/s`, `timeMs`; None where none does."""
    text = _apart(name)
    if found := _IN_BRACKETS.search(text):
        return _ALL_UNITS.get(found[1])
    return _UNITS[found[1]] if (found := _LAST.search(text)) else None


def in_brackets(name: str) -> str:
    """What stands in the brackets that end a name: `mm/s` of `v [mm/s]`; empty where there are none."""
    found = _IN_BRACKETS.search(NUMBERED.sub("", name))
    return found[1] if found else ""


def is_unit(cell: str) -> float | None:
    """Seconds in a unit that stands alone, with or without brackets: `s`, `[ms]`; None where it is none of time."""
    return _ALL_UNITS.get(fold(cell).strip(" []()<>{}"))


def last_part(name: str) -> str:
    """The name within its group, sheet or struct: `Time` of `Force/Time`, `out.Time`."""
    return _PATH.split(name)[-1]


def groups(name: str) -> list[str]:
    """What stands before the name itself, group within group: `a/b/`, `a/` and the empty text of `a/b/Time`."""
    return [*(name[: found.end()] for found in reversed(list(_PATH.finditer(name)))), ""]


def is_time(name: str) -> bool:
    """Whether a name, but for its unit and its group, is nothing but words for a time."""
    words = _tokens(last_part(_without_unit(name)))
    other = _IN_BRACKETS.search(_apart(name))
    if words == ["t"] and other and other[1] not in _ALL_UNITS:
        return False  # T [°C]
    return bool(words) and _TIME_WORDS.issuperset(words)


def speaks_of_time(name: str) -> bool:
    """Whether a name holds a word for a time, is a unit of it, or has one in brackets."""
    unit = _IN_BRACKETS.search(_apart(name))
    words = _tokens(_without_unit(name))
    return (
        is_unit(unit[1] if unit else name) is not None
        or any(len(word) > 1 and word in _TIME_WORDS for word in words)
        or any(map(_LIKE_TIME.fullmatch, words))
    )


def _without_unit(name: str) -> str:
    """A name without the brackets or the unit of time that ends it, if a word is left."""
    text = _apart(name)
    for pattern in (_IN_BRACKETS, _LAST):
        found = pattern.search(text)
        if found and _tokens(text[: found.start()]):
            text = text[: found.start()]
    return text


def _tokens(text: str) -> list[str]:
    return re.findall(r"[^\W\d_]+", _apart(text))


def is_stamp(name: str) -> bool:
    """Whether a name is that of the stamp in the header of a ROS message."""
    return _tokens(name)[-2:] == ["header", "stamp"]


_PAIRS = {"secs": ("nsecs",), "sec": ("nanosec", "nsec", "nanosecs")}


def pairs(names: Iterable[str]) -> list[tuple[str, str]]:
    """Columns that hold whole seconds and the nanoseconds beyond them, as stamps of ROS do."""
    known = list(names)
    found = []
    for name in known:
        for seconds, others in _PAIRS.items():
            if re.fullmatch(rf"(.*[\W_])?{seconds}", name):
                rest = {name[: -len(seconds)] + other for other in others}
                found += [(name, other) for other in known if other in rest]
    return found
