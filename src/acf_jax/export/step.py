"""What a program for other languages is made of: operations on vectors."""

from typing import NamedTuple

import numpy as np


class Value(NamedTuple):
    """What a step computes: a vector of numbers or of flags; a scalar is a vector of one entry."""

    number: int
    size: int
    is_flag: bool


Operand = Value | np.ndarray  # a constant has one entry or as many as the vectors that it meets


class Operation(NamedTuple):
    """The name of JAX's primitive and its operands; 'affine' is W x + b with a constant matrix and vector."""

    op: str
    inputs: tuple[Operand, ...]
    more: tuple[int, ...] = ()  # of slice: start and stop; of integer_pow: the exponent


class Step(NamedTuple):
    """An operation and the name of what it computes."""

    op: str
    inputs: tuple[Operand, ...]
    more: tuple[int, ...]
    output: Value


class Program(NamedTuple):
    """Steps in order, from the sample to the outputs."""

    x: Value
    steps: tuple[Step, ...]
    outputs: tuple[Value, ...]
