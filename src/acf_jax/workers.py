"""Many pieces of work in many processes, on this machine or others, by Dask.

The work is a function that touches no file of the caller's. A result comes back as soon as it is there, and the caller
writes it: a process that dies takes nothing along, since its piece is computed again elsewhere.
"""

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from itertools import chain
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar

from acf_jax import __version__
from acf_jax.errors import InputError

if TYPE_CHECKING:
    from distributed import Client

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


class Lost(RuntimeError):
    """The processes that tried a piece of work died, one after the other."""


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
        yield from _stream(client, work, chain([first], pieces), where)


def _stream(
    client: "Client", work: Callable[[Argument], Result], pieces: Iterator[tuple[Key, Argument]], where: Where
) -> Iterator[tuple[Key, Result | Exception]]:
    from distributed import CancelledError, KilledWorker, as_completed

    keys: dict[str, Key] = {}
    finished = as_completed()

    def hand_out() -> None:
        wanted = AHEAD * max(1, sum(client.nthreads().values()))
        while len(keys) < wanted and (piece := next(pieces, None)) is not None:
            future = client.submit(_start_and, work, piece[1], pure=False)
            keys[future.key] = piece[0]
            finished.add(future)

    hand_out()
    for future in finished:
        outcome: Result | Exception
        try:
            outcome = future.result()
        except CancelledError:
            raise InputError(
                f"{where.option}: went away; start it again and repeat the command, which goes on where it was"
            ) from None
        except KilledWorker as error:
            outcome = Lost(f"{error.allowed_failures + 1} processes died of it; is there enough memory?")
        except Exception as error:
            outcome = error
        yield keys.pop(future.key), outcome
        future.release()
        hand_out()


def _start_and(work: Callable[[Argument], Result], argument: Argument) -> Result:
    """Runs where the work is done."""
    from acf_jax.start import start_jax

    start_jax()
    return work(argument)


@contextmanager
def _client(where: Where) -> Iterator["Client"]:
    """A client of the scheduler, or of processes on this machine."""
    try:
        import dask
        from distributed import Client, LocalCluster
    except ImportError:
        raise InputError("Dask is missing; install it by pip install 'acf-jax[fleet]'") from None
    with dask.config.set(_SETTINGS):
        if where.scheduler is not None:
            with _reached(where.scheduler, where) as client:
                where.say(f"dashboard: {client.dashboard_link}")
                yield client
            return
        options: dict[str, Any] = {"dashboard_address": "127.0.0.1:0", "silence_logs": "CRITICAL"}
        with (
            # One thread each: matrices are tiny, and Dask keeps the threads of the linear algebra to one as well.
            LocalCluster(where.workers, 1, memory_limit=0, **options) as cluster,
            Client(cluster) as client,
        ):
            where.say(f"dashboard: {client.dashboard_link}")
            yield client


def _reached(scheduler: str, where: Where) -> "Client":
    """A client of a scheduler that has workers with this version of acf-jax."""
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
        versions = client.run(_version)
    except TimeoutError:
        client.close()
        raise InputError(
            f"{where.option} {scheduler}: has no workers; start some by `dask worker {scheduler} --nthreads 1`"
        ) from None
    if others := sorted({v for v in versions.values() if v != __version__}):
        client.close()
        raise InputError(
            f"{where.option} {scheduler}: has workers with acf-jax {', '.join(others)}; install {__version__} there"
        )
    return client


def _version() -> str:
    return __version__
