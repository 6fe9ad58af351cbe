"""Charts whose axes could have no length."""

import pytest

from acf_jax.training.charts import Axis, Series, chart


@pytest.mark.parametrize("value", [1000.0, 0.0, -3.0])
def test_a_single_value_stands_in_the_middle(value: float) -> None:
    def places(values: list[float]) -> set[str]:
        drawn = chart(
            "Training", [Series("loss", values, [0.1] * len(values), 0)], Axis("step"), Axis("loss", log=True)
        )
        return set(drawn.split('d="M')[1].split('"')[0].split("L"))

    (single,) = places([value])
    span = abs(value) or 2.0
    assert single in places([value - span / 2, value, value + span / 2])


def test_a_line_of_one_point_is_seen() -> None:
    def dots(values: list[float]) -> int:
        lines = [Series("loss", values, [0.1] * len(values), 0)]
        return chart("Training", lines, Axis("step"), Axis("loss", log=True)).count("<circle")

    assert dots([400.0]) == 1 and dots([400.0, 800.0]) == 0
