"""Worlds that make gap data sets with a hidden cause; they share no code with the fitted simulator."""

from validation.worlds.case import Case, Trial, make_case
from validation.worlds.distance import distance, signature, size_at_distance
from validation.worlds.interface import AbstractCause, AbstractWorld, Impact, Response, Rig, find_world
from validation.worlds.lifelike import make_lifelike
from validation.worlds.setup import Noise, Setup, draw_setup
from validation.worlds.writing import answer_of, write_case, write_data

__all__ = [
    "AbstractCause", "AbstractWorld", "Case", "Impact", "Noise", "Response", "Rig", "Setup", "Trial",
    "answer_of", "distance", "draw_setup", "find_world", "make_case", "make_lifelike", "signature", "size_at_distance",
    "write_case", "write_data",
]  # fmt: skip
