"""Worlds that make gap data sets with a hidden cause; they share no code with the fitted simulator."""

from acf_jax.worlds.case import Case, Trial, make_case
from acf_jax.worlds.distance import distance, signature, size_at_distance
from acf_jax.worlds.interface import AbstractCause, AbstractWorld, Impact, Response, Rig, find_world
from acf_jax.worlds.setup import Noise, Setup, draw_setup
from acf_jax.worlds.writing import answer_of, write_case, write_data

__all__ = [
    "AbstractCause", "AbstractWorld", "Case", "Impact", "Noise", "Response", "Rig", "Setup", "Trial",
    "answer_of", "distance", "draw_setup", "find_world", "make_case", "signature", "size_at_distance",
    "write_case", "write_data",
]  # fmt: skip
