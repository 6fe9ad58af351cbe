"""Whether a name speaks of the head or the face, contact with which is never permissible."""

import functools
import re
import unicodedata

# the standard's areas of skull, forehead and face
NUMBERS = ("1", "2", "3")
STEMS = (
    "augen",
    "crani",
    "facial",
    "forehead",
    "frontal",
    "gesicht",
    "hinterhaupt",
    "jochbein",
    "kiefer",
    "kopf",
    "masseter",
    "mastic",
    "maxill",
    "nasal",
    "nasen",
    "occip",
    "ohrl",
    "parietal",
    "schädel",
    "schaedel",
    "schläfe",
    "schlaefe",
    "skull",
    "stirn",
    "wange",
    "zygom",
)
WORDS = re.compile(
    r"(head|temple|scalp|face|jaw|mandible|eye|eyelid|eyebrow|eyeball|brow|nose|nostril|ear|earlobe|cheek|cheekbone|chin"
    r"|mouth|lip|tooth|teeth|tongue|auge|nase|ohr|kinn|mund|lippe|zahn)(s|es|n|en)?"
)


@functools.cache
def is_of_head(*texts: str) -> bool:
    """Whether a region, a name or a number of an area means head or face; plurals and Head_front included.

    Rather a word too many, such as the head of a bone, than one too few.
    """
    parted = re.sub(r"(?<=[a-z])(?=[A-Z])", " ", " ".join(texts))
    words = re.findall(r"[^\W\d_]+", unicodedata.normalize("NFC", parted).lower())
    is_numbered = any(text in NUMBERS for text in texts)
    return is_numbered or any(_names_it(word) for word in words)


def _names_it(word: str) -> bool:
    return WORDS.fullmatch(word) is not None or any(stem in word for stem in STEMS)
