"""Weighing fitted explanations: what each leaves, what its freedom costs, and the probabilities that follow."""
