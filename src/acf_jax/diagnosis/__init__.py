"""Diagnosing the gap between the paper's model and measured impacts."""
