"""Effects and free curves at their typical shapes."""

from acf_jax.inference.parameters import every_effect


def typical(name: str, **values: float) -> list[float]:
    """Parameters of an effect or free curve, strengths zero and shapes typical where they are not given."""
    known = every_effect()[name].parameters()
    return [values.get(p.name, p.scale if p.shape else 0.0) for p in known]
