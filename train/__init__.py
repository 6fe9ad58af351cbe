"""Run from the repository: `python -m train.fit --config ...`; the work is done by `acf_jax.training`."""
