"""The same on a cluster, by Dask: form factors in brackets and by rays, gathers and the audit.

Work is a list of independent jobs. A scene is sent once to each worker that has a job of it, by its digest. What comes back is put
together exactly: disjoint rows, disjoint pairs, counts, and maxima with a witness. So the result has the same bytes as on one machine,
however the work was cut, whoever did it, and whatever died meanwhile: Dask does the jobs of a dead worker again.

>>> from dask.distributed import Client
>>> client = Client()  # doctest: +SKIP
>>> F = radgrad.distributed.factors(scene, client)  # doctest: +SKIP
"""

from __future__ import annotations

import threading
from typing import TYPE_CHECKING, Any, Callable, Optional, Sequence

import numpy as np
from numpy.typing import ArrayLike

from . import _radgrad
from ._audit import AuditReport, _checked
from ._evaluate import _whole
from ._factors import Factors, settings_of
from ._rays import RayFactors, ray_settings
from ._scene import Scene, _from_bytes
from ._solution import Gathered, Solution, _gathered, _kept as _solution_of, _on_face, _pairs

if TYPE_CHECKING:
    from distributed import Client

#: Jobs for each thread of the cluster, and for each of few: so many that none waits long for the last one.
JOBS_A_THREAD, JOBS_OF_FEW = 8, 32

#: Jobs that the scheduler hands out in no time.
FEW_JOBS = 512

#: Points of a job of `gather` at most: each takes a millisecond or so.
MOST_POINTS = 4096

#: Jobs of `gather` in one message to the scheduler: 50 MB at most.
JOBS_A_MESSAGE = 256

#: What this process was sent, by its digest; and who may make it.
_kept: "dict[str, Any]" = {}
_lock = threading.Lock()


def _keep(digest: str, make: "Callable[[], Any]") -> Any:
    """What was made of a digest, made once in this process."""
    with _lock:
        if digest not in _kept:
            _own_threads()
            _kept[digest] = make()
        return _kept[digest]


def _own_threads() -> None:
    """As many threads as the worker has."""
    try:
        from distributed import get_worker

        _radgrad.threads(get_worker().state.nthreads)
    except (ImportError, ValueError):
        pass


def _threads(client: "Client") -> int:
    count = sum(client.nthreads().values())
    if count == 0:
        raise ValueError("the cluster has no worker yet: wait with client.wait_for_workers(1)")
    return count


def _jobs(client: "Client") -> int:
    """Into how many jobs work is cut."""
    threads = _threads(client)
    return max(JOBS_A_THREAD * threads, min(JOBS_OF_FEW * threads, FEW_JOBS))


def _sent(client: "Client", scene: Scene) -> "tuple[str, Any]":
    """The digest of a scene, and its bytes as a task: made once, handed from worker to worker, and made again if its holder dies."""
    digest = scene.digest
    return digest, client.submit(_held, scene._core.to_bytes(), scene.notes, key=f"radgrad-scene-{digest}")


def _held(content: bytes, notes: "list[str]") -> "tuple[bytes, list[str]]":
    return content, notes


def _scene(digest: str, sent: "tuple[bytes, list[str]]") -> Scene:
    return _keep(digest, lambda: _from_bytes(*sent))


def _block(rows: "tuple[int, int]", digest: str, sent: "tuple[bytes, list[str]]", settings: "dict[str, Any]") -> bytes:
    """A job of `factors`."""
    return _scene(digest, sent)._core.factor_block(settings, *rows).__reduce__()[1][0]


def _cuts(count: int, jobs: int) -> "list[tuple[int, int]]":
    """Even ranges of so many rows."""
    cuts = np.unique(np.linspace(0, count, min(jobs, max(count, 1)) + 1).astype(int)).tolist()
    return list(zip(cuts[:-1], cuts[1:]))


def _blocks(areas: "np.ndarray[Any, Any]", jobs: int) -> "list[tuple[int, int]]":
    """Ranges of rows of about as much work each: row i has the pairs with later rows, and those of a large face take more cells."""
    rows = len(areas)
    pairs = np.arange(rows - 1, -1, -1, dtype=float)
    parts = [of / of.sum() for of in (pairs, pairs * areas) if of.sum() > 0]
    work = np.concatenate([[0], np.cumsum(sum(parts, np.zeros(rows)))])
    cuts = np.searchsorted(work, np.linspace(0, work[-1], min(jobs, max(rows, 1)) + 1))
    cuts[0], cuts[-1] = 0, rows
    cuts = np.unique(cuts)
    return list(zip(cuts[:-1].tolist(), cuts[1:].tolist()))


def _results(client: "Client", futures: "list[Any]") -> "list[Any]":
    """Results in the order of the jobs. Jobs that are not needed any more are cancelled."""
    try:
        return client.gather(futures)
    except BaseException:
        client.cancel(futures)
        raise


def _by_rows(
    client: "Client",
    job: "Callable[..., bytes]",
    scene: Scene,
    settings: "dict[str, Any]",
    cut: "list[tuple[int, int]]",
) -> "list[bytes]":
    """The results of a job on blocks of rows of a scene, in their order."""
    digest, sent = _sent(client, scene)
    # Handed over together, jobs wait at the scheduler for whoever is free; one by one, they go to the holder of the scene.
    return _results(client, client.map(job, cut, digest=digest, sent=sent, settings=settings, pure=False))


def factors(
    scene: Scene,
    client: "Client",
    tolerance: Optional[float] = None,
    relative: Optional[float] = None,
    most_cells: Optional[int] = None,
    estimate: Optional[float] = None,
    most_points: Optional[int] = None,
    jobs: Optional[int] = None,
) -> Factors:
    """`Scene.factors` on a cluster, by blocks of rows: the same bytes.

    Parameters
    ----------
    scene : Scene
        Sent once to each worker.
    client : dask.distributed.Client
        The cluster.
    tolerance, relative, most_cells, estimate, most_points
        As of `Scene.factors`.
    jobs : int, optional
        Into how many blocks the rows are cut: eight for each thread, and more for few threads, unless given.

    Raises
    ------
    ValueError
        As `Scene.factors` does, and if the cluster has no worker.
    """
    settings = settings_of(tolerance, relative, most_cells, estimate, most_points)
    done = _by_rows(client, _block, scene, settings, _blocks(scene._core.row_areas, jobs or _jobs(client)))
    blocks = [_radgrad.FactorBlock.from_bytes(block) for block in done]
    return Factors(scene, scene._core.join(settings, blocks), settings)._warn()


def _rows(rows: "tuple[int, int]", digest: str, sent: "tuple[bytes, list[str]]", settings: "dict[str, Any]") -> bytes:
    """A job of `rays`."""
    return _radgrad.RayCore.count(_scene(digest, sent)._core, settings, *rows)


def rays(
    scene: Scene,
    client: "Client",
    tolerance: Optional[float] = None,
    confidence: Optional[float] = None,
    rays: Optional[int] = None,
    seed: Optional[int] = None,
    drop_below: Optional[float] = None,
    jobs: Optional[int] = None,
) -> RayFactors:
    """`Scene.factors(method="rays")` on a cluster, by blocks of rows: the same bytes.

    Parameters
    ----------
    scene : Scene
        Sent once to each worker.
    client : dask.distributed.Client
        The cluster.
    tolerance, confidence, rays, seed, drop_below
        As of `Scene.factors`.
    jobs : int, optional
        Into how many blocks the rows are cut: eight for each thread, and more for few threads, unless given.

    Raises
    ------
    ValueError
        As `Scene.factors` does, and if the cluster has no worker.
    """
    settings = ray_settings(tolerance, confidence, rays, seed, drop_below)
    # As many rays leave every face.
    done = _by_rows(client, _rows, scene, settings, _cuts(len(scene._core.row_areas), jobs or _jobs(client)))
    return RayFactors(scene, _radgrad.RayCore.join(scene._core, settings, done), settings)


def _job(
    part: "tuple[Any, Any]",
    digests: "tuple[str, str]",
    sent: "tuple[bytes, list[str]]",
    state: bytes,
    request: "dict[str, Any]",
    on_face: Optional[bool],
) -> "tuple[Any, ...]":
    """A job of `gather`."""
    scene = _scene(digests[0], sent)
    solution: Solution = _keep("/".join(digests), lambda: _solution_of(scene, request, state, None))
    points, normals = part
    return solution._core.gather((_whole(points), _whole(normals), on_face, [len(points)]))


def gather(
    solution: Solution,
    points: ArrayLike,
    normals: ArrayLike,
    client: "Client",
    on: Optional[str] = None,
    jobs: Optional[int] = None,
) -> Gathered:
    """`Solution.gather` on a cluster, by blocks of points: the same bytes.

    A worker is sent the scene and the solution once, and solves nothing.

    Parameters
    ----------
    solution : Solution
        What was solved.
    points, normals, on
        As of `Solution.gather`.
    client : dask.distributed.Client
        The cluster.
    jobs : int, optional
        Into how many blocks the points are cut: eight for each thread, more for few threads, and of at most 4096 points each, unless given.

    Raises
    ------
    ValueError
        As `Solution.gather` does, and if the cluster has no worker.
    """
    shape, rows, directions = _pairs(points, normals)
    jobs = jobs or max(_jobs(client), -(-len(rows) // MOST_POINTS))
    digest, sent = _sent(client, solution.scene)
    parts = [(rows[first:end], directions[first:end]) for first, end in _cuts(len(rows), jobs)]
    if not parts:
        return solution.gather(points, normals, on)
    state = client.submit(bytes, solution._core.to_bytes(), key=f"radgrad-solution-{digest}-{solution.digest}")
    given = {"digests": (digest, solution.digest), "sent": sent, "state": state, "request": solution._request, "on_face": _on_face(on)}
    # So many at once that a message stays small.
    futures = client.map(_job, parts, **given, pure=False, batch_size=JOBS_A_MESSAGE)
    found = _results(client, futures)
    return _gathered([np.concatenate(column) for column in zip(*found)], shape, len(solution.scene.channels))


def verify(
    client: "Client", cases: int = 42_000, seed: int = 1, families: Sequence[str] = (), jobs: Optional[int] = None
) -> AuditReport:
    """`radgrad.verify` on a cluster, by shards: the same tables.

    Parameters
    ----------
    client : dask.distributed.Client
        The cluster.
    cases, seed, families
        As of `radgrad.verify`.
    jobs : int, optional
        Into how many shards: eight for each thread, and more for few threads, unless given.
    """
    _checked(cases, seed)
    of = min(jobs or _jobs(client), max(1, cases // 40))
    futures = client.map(_shard, range(of), of=of, cases=cases, seed=seed, families=list(families), pure=False)
    return AuditReport(_radgrad.merge_shards(_results(client, futures)))


def _shard(index: int, of: int, cases: int, seed: int, families: "list[str]") -> str:
    """A job of `verify`."""
    _keep("threads", lambda: True)
    return _radgrad.audit_shard(cases, seed, families, index, of)
