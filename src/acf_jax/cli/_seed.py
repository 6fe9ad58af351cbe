"""The option of every command that draws at random."""

import click

SEED = click.IntRange(0, 2**31 - 1)  # of all that is drawn
