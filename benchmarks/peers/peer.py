"""One competitor of the speed comparison."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.box import Column


@dataclass(frozen=True)
class Peer:
    """What is timed, and how to see afterwards that it answered the question."""

    name: str
    call: Callable[[], Any]  # timed
    answers: Callable[[Any], Column]  # its result as rows (F_max, t_max) of `chosen`; not timed
    chosen: NDArray[np.intp]  # the samples of the box that it solves
