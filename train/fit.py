"""Train a surrogate of the peak force: `python -m train.fit --config configs/table1.yaml`.

`acf_jax.training` does the work; `python -m acf_jax train` is the same for a diagnosis without a configuration.
"""

import argparse
import shlex
import sys
from collections.abc import Sequence
from pathlib import Path

import acf_jax
from acf_jax.cli._ending import end_well
from acf_jax.cli._stale import foreign_training
from acf_jax.cli._training import train
from acf_jax.errors import InputError
from acf_jax.provenance import Origin, digest_of
from acf_jax.start import start_jax
from acf_jax.training.config import AnyConfig, CorrectedConfig, read_config
from acf_jax.training.devices import join_processes


def main(argv: Sequence[str] | None = None) -> int:
    """Train as the configuration says; the exit code is 1 for a loss that diverges, else as every command's."""
    about = __doc__.split("\n")[0]
    parser = argparse.ArgumentParser(prog="python -m train.fit", description=about, allow_abbrev=False)
    parser.add_argument("--config", type=Path, required=True, help="YAML file, such as configs/table1.yaml")
    parser.add_argument("--resume", action="store_true", help="go on from the run's last checkpoint")
    parser.add_argument(
        "--set", action="append", default=[], metavar="KEY=VALUE", help="change one key: optimiser.steps=1000"
    )
    parser.add_argument(
        "--overwrite", action="store_true", help="also overwrite files that acf-jax did not write"
    )
    parser.add_argument("--json", action="store_true", help="print JSON: metrics.json")
    parser.add_argument("--version", action="version", version=f"%(prog)s, version {acf_jax.__version__}")
    arguments = parser.parse_args(argv)

    def work() -> int:
        config = read_config(arguments.config, tuple(arguments.set))
        if faults := foreign_training(config.output, arguments.overwrite):
            raise InputError(faults)
        join_processes(config)
        start_jax()
        made_of = {str(path): digest_of(path) for path in _inputs(arguments.config, config)}
        line = sys.argv[1:] if argv is None else argv
        origin = Origin(shlex.join(["python", "-m", "train.fit", *line]), made_of)
        return train(lambda: config, origin, arguments.resume, arguments.json)

    return end_well(work)


def _inputs(path: Path, config: AnyConfig) -> list[Path]:
    """The configuration, and the diagnosis' model that it names; the run itself says that it is missing."""
    paths = [path, config.labels.model] if isinstance(config, CorrectedConfig) else [path]
    return [p for p in paths if p.exists()]


if __name__ == "__main__":
    sys.exit(main())
