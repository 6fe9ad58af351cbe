"""What a person reads of a diagnosis."""

from acf_jax.report.words import doubts as doubts
from acf_jax.report.words import sentence as sentence
from acf_jax.report.words import told as told
from acf_jax.report.write import save_diagnosis as save_diagnosis
from acf_jax.report.write import write_report as write_report
