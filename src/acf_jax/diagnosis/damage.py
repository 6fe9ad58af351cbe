"""What damage of the data takes from a verdict: no probability is stated that the damage may have made."""

from collections.abc import Sequence

from acf_jax.dataset import Quality
from acf_jax.evidence.posterior import UNKNOWN, Posterior, ranked

EVEN = 0.5  # probability that a damaged trial shows its damage rather than the rig: nothing more is known
AT_MOST = 0.99  # where there is any damage


def highest_probability(quality: Quality, compared: Sequence[str]) -> float:
    """The probability, at most, of a verdict on these trials: 1 where none of them is damaged.

    A verdict rests on its trials in equal shares. What a damaged one shows is the rig or its damage, with even odds as
    long as nothing else is known; so damage made the verdict with half of the damaged share, and no more than the rest
    is its probability. Trials that are left out, and damage that is mended, take nothing from it.
    """
    share = len(set(quality.damaged) & set(compared)) / len(compared)
    return min(AT_MOST, 1 - EVEN * share) if share else 1.0


def tempered(told: Posterior, highest: float) -> Posterior:
    """The posterior, nothing above `highest`: what the first explanation loses goes to a cause outside the library.

    Where that leads itself, to nothing unmodelled: then the damage is all there is.
    """
    first = told.scored[0]
    if first.probability <= highest:
        return told
    total = dict(told.scored)
    other = () if first.explanation == UNKNOWN else UNKNOWN
    total[first.explanation] = highest
    # no more than what is left of one, which rounding may exceed
    total[other] = min(total.get(other, 0.0) + first.probability - highest, 1 - highest)
    # at even odds another may be as probable: the first one stays first
    scored = sorted(ranked(total), key=lambda s: (-s.probability, s.explanation != first.explanation))
    return told._replace(scored=tuple(scored))


def statements(quality: Quality, compared: Sequence[str], highest: float) -> list[str]:
    """Why no verdict is surer, in words; nothing where no trial is damaged."""
    if highest == 1.0:
        return []
    count = len(set(quality.damaged) & set(compared))
    return [
        f"no probability above {100 * highest:.0f} % is stated: {count} of the {len(compared)} trials compared are"
        " damaged, and what one of these shows may as well be its damage"
    ]
