"""A cluster: form factors by blocks of rows, gathers by blocks of points, the audit by shards, with the same bytes as here.

    python on_a_cluster.py [scene.obj]

In place of a `LocalCluster` stand any other one of Dask's: `SLURMCluster`, `KubeCluster`, `SSHCluster`, ...
"""

# %% Two processes on this machine
import sys
import time

import numpy as np

import radgrad as rg

try:
    from distributed import Client, LocalCluster
except ImportError:
    raise SystemExit("SKIPPED: dask.distributed is not installed")


def main():
    corners = [[x, y, z] for z in (0.0, 1.0) for y in (0.0, 1.0) for x in (0.0, 1.0)]
    walls = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    scene = rg.Scene.read(sys.argv[1]) if len(sys.argv) > 1 else rg.Scene(corners, walls, emission=[0, 1, 0, 0, 0, 0])
    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster, Client(cluster) as client:
        # %% Factors: a scene is sent once to each worker, and pairs come back, each computed once
        start = time.perf_counter()
        F = rg.distributed.factors(scene, client)
        print(f"factors: {F.data.size} in {time.perf_counter() - start:.1f} s, closure {F.closure:.1e}")
        assert F.tobytes() == scene.factors().tobytes()

        # %% Gathers: workers solve the scene themselves, and compare the digest of what they found
        solution = scene.solve(error=0.05)
        points = np.random.default_rng(1).random((400, 3))
        found = rg.distributed.gather(solution, points, [0, 0, 1], client)
        print(f"gathers: mean irradiance {found.irradiance.mean():.4f}")
        assert found.irradiance.tobytes() == solution.gather(points, [0, 0, 1]).irradiance.tobytes()

        # %% The audit: counts, and maxima with their case
        report = rg.distributed.verify(client, cases=200, seed=1)
        print(f"audit: {len(report)} cases in {len(report.outcomes)} families")
        assert report.csv("errors") == rg.verify(cases=200, seed=1).csv("errors")


if __name__ == "__main__":
    main()
