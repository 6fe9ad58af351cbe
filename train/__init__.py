"""Train a surrogate of the peak force; run from the repository: `python -m train.fit --config ...`."""
