"""`python -m validation.blind` is `python -m acf_jax blind`."""

import sys

from acf_jax.cli.main import main

main(["blind", *sys.argv[1:]])
