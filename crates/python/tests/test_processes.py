"""Processes that fork or spawn, threads that share a scene, and how many threads compute."""

import concurrent.futures
import ctypes
import ctypes.util
import multiprocessing
import os
import subprocess
import sys
import threading

import numpy as np
import pytest

import radgrad as rg
from conftest import counting

CAN_FORK = "fork" in multiprocessing.get_all_start_methods() and sys.platform.startswith("linux")
LAMP = [[0, 0, 1], [0, 1, 1], [1, 1, 1], [1, 0, 1]]
LONG = np.random.default_rng(1).random((200_000, 3)) * [1, 1, 0.5]


def of_points(count):
    return rg.evaluate(LONG[:count], [0, 0, 1], rg.Emitter(LAMP)).radiosity.tobytes()


def of_factors(room):
    return room.factors().tobytes()


def of_a_solve(room):
    return room.solve(error=0.02).digest


def of_a_gather(solution):
    return solution.gather([[0.5, 0.5, 0.0]], [0, 0, 1]).radiosity.tobytes()


def of_the_audit(cases):
    return rg.verify(cases=cases, families=["generic"]).csv("figures")


@pytest.mark.skipif(not CAN_FORK, reason="there is no fork here")
@pytest.mark.filterwarnings("ignore::DeprecationWarning")
@pytest.mark.parametrize("work", ["points", "factors", "solve", "gather", "audit"])
def test_a_forked_process_computes_the_same_after_its_parent_did(room, work):
    of, argument = {
        "points": (of_points, 100_000),
        "factors": (of_factors, room),
        "solve": (of_a_solve, room),
        "gather": (of_a_gather, room.solve(error=0.02)),
        "audit": (of_the_audit, 40),
    }[work]
    here = of(argument)
    with multiprocessing.get_context("fork").Pool(2) as pool:
        assert pool.map_async(of, [argument] * 3).get(timeout=120) == [here] * 3


@pytest.mark.parametrize("work", ["points", "factors", "solve", "gather"])
def test_a_spawned_process_computes_the_same(room, work):
    of, argument = {
        "points": (of_points, 1000),
        "factors": (of_factors, room),
        "solve": (of_a_solve, room),
        "gather": (of_a_gather, room.solve(error=0.02)),
    }[work]
    with concurrent.futures.ProcessPoolExecutor(1, mp_context=multiprocessing.get_context("spawn")) as pool:
        assert pool.submit(of, argument).result(timeout=120) == of(argument)


@pytest.mark.skipif(not CAN_FORK, reason="there is no fork here")
def test_what_is_forked_amid_a_computation_is_refused_at_once():
    program = """if True:
        import os, sys, threading, time, warnings, numpy as np, radgrad as rg
        warnings.simplefilter("ignore")
        lamp = rg.Emitter([[0, 0, 1], [0, 1, 1], [1, 1, 1], [1, 0, 1]])
        screens = [[[0.1 * i, 0, 0.5], [0.1 * i + 0.05, 0, 0.5], [0.1 * i + 0.05, 1, 0.5]] for i in range(10)]
        x = np.random.default_rng(1).random((400_000, 3)) * [1, 1, 0.1]
        thread = threading.Thread(target=lambda: rg.evaluate(x, [0, 0, 1], lamp, screens), daemon=True)
        thread.start()
        time.sleep(0.5)
        child = os.fork()
        if child == 0:
            try:
                rg.evaluate([0, 0, 0], [0, 0, 1], lamp)
                os._exit(1)
            except RuntimeError as refusal:
                os._exit(0 if "spawn" in str(refusal) else 2)
        for _ in range(600):
            done, status = os.waitpid(child, os.WNOHANG)
            if done:
                os._exit(os.waitstatus_to_exitcode(status))
            time.sleep(0.05)
        os._exit(3)
    """
    assert subprocess.run([sys.executable, "-c", program], timeout=120).returncode == 0


@pytest.mark.parametrize("work", ["factors", "gather", "evaluate", "check", "solve"])
def test_threads_share_a_scene(room, work):
    solution = room.solve(error=0.02)
    calls = {
        "factors": lambda: rg.Scene.__dict__["factors"](room).tobytes(),
        "gather": lambda: of_a_gather(solution),
        "evaluate": lambda: of_points(5000),
        "check": lambda: room.check(),
        "solve": lambda: of_a_solve(room),
    }
    call = calls[work]
    with concurrent.futures.ThreadPoolExecutor(6) as pool:
        found = [future.result(timeout=120) for future in [pool.submit(call) for _ in range(12)]]
    assert all(one == found[0] for one in found)


def test_how_many_threads_is_a_context():
    before = rg.threads().count
    with rg.threads(1) as one:
        assert one.count == 1 and int(rg.threads()) == 1
        alone = of_points(50_000)
        with rg.threads(3):
            assert rg.threads().count == 3 and of_points(50_000) == alone
        assert rg.threads().count == 1
    assert rg.threads().count == before and "threads" in repr(rg.threads())
    with pytest.raises(LookupError):
        with rg.threads(1):
            raise LookupError
    assert rg.threads().count == before
    for wrong in (-1, 1.5, True, 10**6):
        with pytest.raises(ValueError, match="count"):
            rg.threads(wrong)


def test_threads_that_are_set_while_others_compute_change_nothing():
    wanted, found = of_points(20_000), []
    workers = [threading.Thread(target=lambda: found.append(of_points(20_000))) for _ in range(4)]
    for worker in workers:
        worker.start()
    for count in (1, 2, 3):
        rg.threads(count)
    for worker in workers:
        worker.join(timeout=60)
    rg.threads(0)
    assert found == [wanted] * 4


@pytest.fixture
def rounded_up():
    """The rounding mode that another library of the process may leave."""
    if not (sys.platform.startswith("linux") and os.uname().machine == "x86_64"):
        pytest.skip("the rounding mode is set here for x86-64 Linux")
    libm = ctypes.CDLL(ctypes.util.find_library("m"))
    assert libm.fesetround(0x800) == 0
    try:
        yield
    finally:
        libm.fesetround(0)


def test_another_rounding_is_refused_at_every_door(room, data, tmp_path, request):
    lamp, solution, factors = rg.Emitter(LAMP), room.solve(error=0.05), room.factors()
    tree, x, up = rg.EmitterTree([lamp]), [0.5, 0.5, 0.0], [0, 0, 1]
    doors = [
        lambda: rg.evaluate(x, up, lamp),
        lambda: rg.each(x, up, [lamp]),
        lambda: rg.hessian(x, up, lamp),
        lambda: rg.derivatives(x, up, lamp),
        lambda: rg.digits(x, up, lamp),
        lambda: rg.irradiance_vector(x, up, lamp),
        lambda: tree.total(x, up, atol=1e-3),
        lambda: rg.EmitterTree([lamp]),
        lambda: rg.Scene.read(data / "scenes/cornell.obj"),
        lambda: rg.Scene([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]]),
        lambda: room.check(),
        lambda: room.replaced(reflectance=0.25),
        lambda: room.factors(tolerance=0.5),
        lambda: factors.repaired(),
        lambda: factors.write(tmp_path / "f.csv"),
        lambda: room.solve(error=0.5),
        lambda: solution.gather(x, up),
        lambda: solution.gradient(x, up),
        lambda: solution.certify(width=0.5),
        lambda: solution.image(([0.5, 0.1, 0.5], [0.5, 1, 0.5], [0, 0, 1], 60), size=(4, 4)),
        lambda: solution.to_vtu(tmp_path / "s.vtu"),
        lambda: rg.verify(cases=6, families=["generic"]),
    ]
    request.getfixturevalue("rounded_up")
    for index, door in enumerate(doors):
        with pytest.raises(ValueError, match="round"):
            door()
            pytest.fail(f"door {index} is open")


def test_a_long_call_leaves_pythons_lock(data):
    with counting() as counted:
        rg.Scene.read(data / "scenes/two_blocks.obj").factors(tolerance=0.02)
    assert counted[0] > 0
