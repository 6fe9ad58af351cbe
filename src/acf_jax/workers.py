"""Many pieces of work in many processes, on this machine or others, by Dask.

The work is a function that touches no file of the caller's. A result comes back as soon as it is there, and the caller
writes it: a process that dies takes nothing along, since its piece is computed again elsewhere.
"""

import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from importlib.util import find_spec
from itertools import chain
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar
from zipfile import ZipFile

from acf_jax import __version__
from acf_jax.errors import InputError

if TYPE_CHECKING:
    from distributed import Client, Future

Key = TypeVar("Key")
Argument = TypeVar("Argument")
Result = TypeVar("Result")

AHEAD = 2  # pieces that wait for each process: it is never idle, and memory does not grow with their number
REACH_S, PATIENCE_S = 10, 60  # how long a scheduler may not answer, and may have no worker


# Dask has its processes give every freed page back at once, which costs a diagnosis a fifth of its time.
_MALLOC = {"MALLOC_TRIM_THRESHOLD_": 2**29, "MALLOC_MMAP_THRESHOLD_": 2**28}
_SETTINGS: dict[str, Any] = {
    "distributed.admin.large-graph-warning-threshold": "1GB",
    **{f"distributed.nanny.pre-spawn-environ.{name}": size for name, size in _MALLOC.items()},
}


class Where(NamedTuple):
    """On what the work runs."""

    scheduler: str | None = None  # address of a Dask scheduler; None: processes on this machine
    workers: int = 2  # how many of these
    say: Callable[[str], None] = lambda text: None  # told where the dashboard is
    option: str = "--scheduler"  # where the user gave the address, for messages
    again: str = "the same command goes on where it was"  # what to do after a failure


class Lost(RuntimeError):
    """The processes that tried a piece of work died, one after the other."""


class CannotStart(RuntimeError):
    """A process has none of the devices that its environment asks for."""


def run_all(
    work: Callable[[Argument], Result], pieces: Iterable[tuple[Key, Argument]], where: Where
) -> Iterator[tuple[Key, Result | Exception]]:
    """Do `work` on each piece; yields its key with the result or the error, in the order of finishing.

    **Arguments:** `work`: importable by its name. `pieces`: key and argument; read as they are needed.

    **Raises:** `InputError` where Dask is missing, or the scheduler cannot be reached, has no workers or goes away.
    """
    pieces = iter(pieces)
    if (first := next(pieces, None)) is None:
        return  # nothing to do needs no processes
    with _client(where) as client:
        if where.scheduler is not None:
            with _answering(where):
                _bring(client, work.__module__)
        yield from _stream(client, work, chain([first], pieces), where)


def _stream(
    client: "Client", work: Callable[[Argument], Result], pieces: Iterator[tuple[Key, Argument]], where: Where
) -> Iterator[tuple[Key, Result | Exception]]:
    from distributed import as_completed

    keys: dict[str, Key] = {}
    finished = as_completed()

    def hand_out() -> None:
        with _answering(where):
            wanted = AHEAD * max(1, sum(client.nthreads().values()))
        while len(keys) < wanted and (piece := next(pieces, None)) is not None:
            with _answering(where):
                future = client.submit(_start_and, work, piece[1], pure=False)
            keys[future.key] = piece[0]
            finished.add(future)

    hand_out()
    for future in finished:
        yield keys.pop(future.key), _outcome(future, where)
        future.release()
        hand_out()


def _outcome(future: "Future", where: Where) -> Any:
    """What came of a piece: the result of its work, or the error."""
    from distributed import KilledWorker

    with _answering(where):
        try:
            return future.result()
        except KilledWorker as error:
            return Lost(f"{error.allowed_failures + 1} processes died of it; is there enough memory?")
        except CannotStart as error:
            raise InputError(str(error)) from None
        except Exception as error:
            if future.status in ("finished", "cancelled"):  # it is not the work that failed
                raise
            return error


@contextmanager
def _answering(where: Where) -> Iterator[None]:
    """`InputError` where the scheduler went away; once Dask has tried for a while to reach it again."""
    from distributed import CancelledError
    from distributed.client import ClosedClientError

    try:
        yield
    except (OSError, CancelledError, ClosedClientError):
        raise InputError(f"{where.option}: went away; start it again, then {where.again}") from None


def _start_and(work: Callable[[Argument], Result], argument: Argument) -> Result:
    """Runs where the work is done."""
    from acf_jax.start import start_jax

    try:
        start_jax()
    except InputError as error:
        raise CannotStart(str(error)) from None
    return work(argument)


@contextmanager
def _client(where: Where) -> Iterator["Client"]:
    """A client of the scheduler, or of processes on this machine."""
    try:
        import dask
        from distributed import Client, LocalCluster
        from distributed.utils import silence_logging_cmgr
    except ImportError:
        raise InputError("Dask is missing; install it by pip install 'acf-jax[fleet]'") from None
    with dask.config.set(_SETTINGS):
        if where.scheduler is not None:
            # What Dask says of a connection that breaks is said here in one line.
            with silence_logging_cmgr("CRITICAL"), _reached(where.scheduler, where) as client:
                where.say(f"dashboard: {client.dashboard_link}")
                yield client
            return
        options: dict[str, Any] = {"dashboard_address": "127.0.0.1:0", "silence_logs": "CRITICAL"}
        with (
            # One thread each: matrices are tiny, and Dask keeps the threads of the linear algebra to one as well.
            LocalCluster(n_workers=where.workers, threads_per_worker=1, memory_limit=0, **options) as cluster,
            Client(cluster) as client,
        ):
            where.say(f"dashboard: {client.dashboard_link}")
            yield client


def _reached(scheduler: str, where: Where) -> "Client":
    """A client of a scheduler that has workers, all of them with this version of acf-jax."""
    from distributed import Client

    try:
        client = Client(scheduler, timeout=REACH_S)
    except (OSError, ValueError) as error:
        raise InputError(
            f"{where.option} {scheduler}: cannot be reached ({error}); start one by `dask scheduler`, and workers by "
            f"`dask worker {scheduler} --nthreads 1`"
        ) from None
    try:
        client.wait_for_workers(1, timeout=PATIENCE_S)
        versions = {*client.run(_version).values(), client.run_on_scheduler(_version)}
    except TimeoutError:
        client.close()
        raise InputError(
            f"{where.option} {scheduler}: has no workers; start some by `dask worker {scheduler} --nthreads 1`"
        ) from None
    except Exception as error:  # what they raise arrives as an exception of no certain kind
        client.close()
        raise InputError(
            f"{where.option} {scheduler}: it or a worker cannot use acf-jax ({error}); install {__version__} there"
        ) from None
    if others := sorted(versions - {__version__}):
        client.close()
        raise InputError(
            f"{where.option} {scheduler}: it or a worker has acf-jax {', '.join(others)}; install {__version__} there"
        )
    return client


def _version() -> str:
    return __version__


def _bring(client: "Client", module: str) -> None:
    """Send the package of a module to a scheduler and its workers where they lack it: not all work is installed."""
    if all([*client.run(_knows, module).values(), client.run_on_scheduler(_knows, module)]):
        return
    name = module.partition(".")[0]
    folder = Path(sys.modules[name].__path__[0])
    with TemporaryDirectory() as scratch:
        archive = Path(scratch) / f"{name}.zip"
        with ZipFile(archive, "w") as packed:
            for file in sorted(folder.rglob("*.py")):
                packed.write(file, file.relative_to(folder.parent))
        client.upload_file(str(archive))


def _knows(module: str) -> bool:
    try:
        return find_spec(module) is not None
    except ModuleNotFoundError:  # of the package that it is in
        return False
