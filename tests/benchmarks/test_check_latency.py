"""Calls of ONNX Runtime, timed with and without arrays that are bound once."""

import pytest

from benchmarks.check_latency import bare_network, in_onnx_runtime


@pytest.mark.parametrize("bound", [False, True])
@pytest.mark.parametrize("outputs", [1, 3])
def test_a_model_of_any_outputs_is_timed(outputs: int, bound: bool) -> None:
    spent = in_onnx_runtime(bare_network(2, 4, outputs), [0.5, None], [0.1, 0.2], bound)
    assert len(spent) == 2 and min(spent) > 0
