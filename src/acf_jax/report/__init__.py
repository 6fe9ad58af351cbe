"""What a person reads of a diagnosis."""

from acf_jax.report.words import doubts as doubts
from acf_jax.report.words import made_of as made_of
from acf_jax.report.words import sentence as sentence
from acf_jax.report.write import write_report as write_report
