"""A cluster of two processes, one of which is killed in the middle, gives the same bytes as one machine."""

import os
import signal
import threading
import time

import numpy as np
import pytest

import radgrad as rg

distributed = pytest.importorskip("distributed", reason="dask.distributed is not installed")


@pytest.fixture()
def client():
    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None, silence_logs=50) as cluster:
        with distributed.Client(cluster) as client:
            client.wait_for_workers(2)
            yield client


@pytest.fixture(scope="module")
def scene(data):
    return rg.Scene.read(data / "scenes/two_blocks.obj")


def killed_half_way(client, work):
    """Runs work while a worker is killed once it has a part of it done; returns its result, and whether the worker died."""
    doomed = list(client.run(os.getpid).values())[0]
    before = time.monotonic()
    killed, ended = [], threading.Event()

    def kill():
        # Done jobs stay in the scheduler's memory.
        while not ended.is_set() and time.monotonic() - before < 120:
            try:
                done = client.run_on_scheduler(lambda dask_scheduler: sum(t.state == "memory" for t in dask_scheduler.tasks.values()))
            except OSError:  # the test has failed otherwise, and the cluster is gone
                return
            if done > 2:
                os.kill(doomed, signal.SIGKILL)
                killed.append(doomed)
                return
            time.sleep(0.01)

    watcher = threading.Thread(target=kill)
    watcher.start()
    try:
        result = work()
    finally:
        ended.set()
        watcher.join()
    return result, bool(killed)


def test_factors_are_the_same_bytes_with_a_worker_killed(client, scene):
    alone = scene.factors(tolerance=0.01)
    found, killed = killed_half_way(client, lambda: rg.distributed.factors(scene, client, tolerance=0.01, jobs=12))
    assert killed and found.tobytes() == alone.tobytes()
    assert found.closure == alone.closure


def test_rays_are_the_same_bytes_with_a_worker_killed(client, scene):
    asked = {"rays": 20_000, "drop_below": 1e-3}
    alone = scene.factors(method="rays", **asked)
    found, killed = killed_half_way(client, lambda: rg.distributed.rays(scene, client, jobs=40, **asked))
    assert killed and found == alone


def test_gathers_are_the_same_bytes_with_a_worker_killed(client, room):
    solution = room.solve(error=0.05)
    points = np.random.default_rng(1).random((4000, 3)) * [1, 1, 0]
    points[::2, 2] = 0.5  # on the floor and in free space
    alone = solution.gather(points, [0, 0, 1])
    found, killed = killed_half_way(client, lambda: rg.distributed.gather(solution, points, [0, 0, 1], client, jobs=40))
    assert killed
    for name in ("radiosity", "estimate", "irradiance", "irradiance_estimate", "face"):
        assert getattr(found, name).tobytes() == getattr(alone, name).tobytes()


def test_audits_are_the_same_tables_with_a_worker_killed(client):
    alone = rg.verify(cases=800, seed=5)
    found, killed = killed_half_way(client, lambda: rg.distributed.verify(client, cases=800, seed=5, jobs=16))
    assert killed
    for table in ("outcomes", "errors", "figures", "histogram"):
        assert found.csv(table) == alone.csv(table)


def test_a_scene_is_sent_once_to_a_worker(client, scene):
    rg.distributed.factors(scene, client, tolerance=0.1, jobs=10)
    kept = client.run(lambda: list(__import__("radgrad.distributed").distributed._kept))
    assert len(kept) == 2 and all(names == [scene.digest] for names in kept.values())


def test_what_is_wrong_is_refused_as_on_one_machine(client, room):
    with pytest.raises(ValueError, match="tolerance is -1"):
        rg.distributed.factors(room, client, tolerance=-1)
    with pytest.raises(ValueError, match="point"):
        rg.distributed.gather(room.solve(error=0.1), [[9, 9, 9]], [0, 0, 1], client, on="face")
