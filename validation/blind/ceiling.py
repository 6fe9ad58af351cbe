"""How often the best method there is would name a weak effect: a miss is told from an impossibility."""

from collections.abc import Sequence

import numpy as np

from acf_jax.diagnosis.identifiability import BAYES_ERROR, bayes_error
from validation.blind.plan import SHARES, WEAK
from validation.worlds import AbstractCause, AbstractWorld, Case, Setup, find_world
from validation.worlds.distance import sensed
from validation.worlds.imitation import Imitation

FORMS = 32  # that each effect is drawn in: the fewer, the more the very form of the true one tells
SMALL = 0.05  # size at which a form is drawn: its signature is taken as proportional to its size
SIZES = np.exp(np.linspace(np.log(WEAK[0]), np.log(60.0), 12))  # whitened distances that an effect may have
DRAWS = 4000  # of the noise


def ceiling(case: Case) -> float:
    """Probability that the Bayes decision between no effect and every single effect finds the case's.

    It is told what no user knows: the rig about which to linearise, the noise and how often each cause comes. Every
    effect comes in forms drawn from the world, each at any size; the true form is among them, so the fewer there are
    the more it is told of that one too. Signals are whitened, and projected off what nominal parameters and nuisances
    can imitate. An effect that the best method
    confuses with the true signal more than one time in ten counts as found.
    """
    gram, labels, rng = signals(case)
    return decide(gram, labels, case.distance, rng)


def signals(case: Case, forms: int = FORMS) -> tuple[np.ndarray, list[str], np.random.Generator]:
    """Inner products of the signals of the case and of every effect, whose they are, and the generator of draws.

    Each effect is drawn in `forms` forms.
    """
    world, setup = find_world("scipy"), case.setup
    (true,) = case.causes
    imitation = Imitation(setup, sensed(find_world(case.world), setup, list(case.causes.values())))
    lasting = [imitation.time[recorded] for recorded in imitation.recorded]
    nominal = _forces(world, setup, [], lasting)
    rng = np.random.default_rng(case.seed)
    labels = [true]
    drawn = [imitation.left()]
    for name in world.causes("library"):
        for seed in rng.integers(2**31, size=forms).tolist():
            labels.append(name)
            forces = _forces(world, setup, [world.draw(name, seed, setup.rig, SMALL)], lasting)
            drawn.append([f - without for f, without in zip(forces, nominal, strict=True)])
    return imitation.gram(drawn), labels, rng


def _forces(
    world: AbstractWorld, setup: Setup, causes: Sequence[AbstractCause], lasting: Sequence[np.ndarray]
) -> list[np.ndarray]:
    """The sensed force of each condition at the times of `lasting`, N."""
    return [
        world.respond(setup.rig, causes, impact, time, after_loss=np.inf).sensed
        for impact, time in zip(setup.conditions, lasting, strict=True)
    ]


def decide(gram: np.ndarray, labels: Sequence[str], size: float, rng: np.random.Generator) -> float:
    """How often the first signal's label, or one that it can be taken for, is named; arguments of `weigh`."""
    odds, right = weigh(gram, labels, size, rng)
    return float((right & (odds > 1.0)).mean())


def weigh(
    gram: np.ndarray, labels: Sequence[str], size: float, rng: np.random.Generator
) -> tuple[np.ndarray, np.ndarray]:
    """Odds of the most probable effect against none, and whether it counts as found: both (draws of the noise,).

    `gram`: the inner products (k, k) of all signals. `size`: whitened distance of the first; 0: there is no effect.
    """
    lengths = np.sqrt(np.diag(gram))
    keep = lengths > 1e-9
    keep[0] = True
    cosine = gram[np.ix_(keep, keep)] / np.outer(lengths[keep], lengths[keep])
    names = np.array(labels)[keep]
    values, vectors = np.linalg.eigh(cosine)
    noise = rng.standard_normal((DRAWS, len(values))) * np.sqrt(np.maximum(values, 0.0)) @ vectors.T
    seen = size * cosine[0] + noise  # (draws, signals): along each direction, of unit noise
    likelihood = np.exp(seen[..., None] * SIZES - SIZES**2 / 2).mean(-1)
    kinds = sorted(set(names))
    score = np.stack([likelihood[:, names == kind].mean(1) for kind in kinds], 1)
    odds = score * SHARES["single"] / len(kinds) / SHARES["none"]
    apart = size * np.sqrt(np.maximum(1 - np.maximum(cosine[0], 0.0) ** 2, 0.0))
    same = [k for k, kind in enumerate(kinds) if bayes_error(apart[names == kind].min()) > BAYES_ERROR]
    return odds.max(1), np.isin(odds.argmax(1), [kinds.index(labels[0]), *same])
