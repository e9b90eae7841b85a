"""Ctrl-C is heard, and Python's lock is free meanwhile."""

import os
import signal
import sys
import threading
import time

import numpy as np
import pytest

import radgrad as rg
from conftest import counting

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="signals are another matter on Windows")


def interrupted(after, work):
    """Runs work, with Ctrl-C after so many seconds; returns how long it took, what came out and how far another thread counted."""
    with counting() as counted:
        timer = threading.Timer(after, lambda: os.kill(os.getpid(), signal.SIGINT))
        # A shell's background jobs, as those of a build, ignore it from the start.
        before = signal.signal(signal.SIGINT, signal.default_int_handler)
        start = time.monotonic()
        timer.start()
        try:
            result = work()
        except KeyboardInterrupt as caught:
            result = caught
        took = time.monotonic() - start
        timer.cancel()
        signal.signal(signal.SIGINT, before)
    return took, result, counted[0]


def test_a_long_batch_ends_at_ctrl_c():
    lamp = rg.Emitter([[0, 0, 1], [0, 1, 1], [1, 1, 1], [1, 0, 1]], [1, 2, 3, 2])
    screens = [[[0.1 * i, 0, 0.5], [0.1 * i + 0.05, 0, 0.5], [0.1 * i + 0.05, 1, 0.5]] for i in range(10)]
    x = np.random.default_rng(1).random((2_000_000, 3)) * [1, 1, 0.1]
    took, result, counted = interrupted(0.5, lambda: rg.evaluate(x, [0, 0, 1], lamp, screens))
    assert isinstance(result, KeyboardInterrupt), "it ended before"
    assert took < 10 and counted > 20


def test_a_solve_gives_its_last_round_at_ctrl_c(data):
    scene = rg.Scene.read(data / "scenes/two_blocks.obj")
    rounds = []
    took, result, counted = interrupted(1.0, lambda: scene.solve(error=1e-6, progress=rounds.append))
    assert isinstance(result, rg.Solution) and counted > 20
    assert result.summary["rounds"] == len(rounds) >= 1 and result.summary["estimate"] > 1e-6


LONG = {
    "hessian": lambda of: rg.hessian(of["x"][:300_000], [0, 0, 1], of["lamp"], of["screens"]),
    "derivatives": lambda of: rg.derivatives(of["x"][:300_000], [0, 0, 1], of["lamp"], of["screens"]),
    "each": lambda of: rg.each(of["x"], [0, 0, 1], [of["lamp"]] * 8),
    "irradiance_vector": lambda of: rg.irradiance_vector(of["x"], [0, 0, 1], [of["lamp"]] * 30),
    "total": lambda of: rg.EmitterTree([of["lamp"]] * 500).total(of["x"], [0, 0, 1], atol=1e-12),
    "verify": lambda of: rg.verify(cases=10**7),
    "factors": lambda of: of["scene"].factors(tolerance=1e-5),
    "gather": lambda of: of["solution"].gather(of["places"], [0, 0, 1], on="free"),
    "certify": lambda of: of["solution"].certify(width=1e-6, rays=10**12),
    "certify points": lambda of: of["solution"].certify(points=(of["places"][:1000], [0, 0, 1]), width=1e-6),
    "image": lambda of: of["solution"].image(([0.5, 0.5, 0.5], [0.5, 0.5, 0.0], [0, 1, 0], 60), size=(2000, 2000)),
    "digits": lambda of: rg.digits([0.5, 0.5, 0.0], [0, 0, 1], of["lamp"], of["screens"] * 40, digits=1000),
    "gradient": lambda of: of["solution"].gradient(of["places"], [0, 0, 1], on="free"),
}


@pytest.fixture(scope="module")
def long(room, data):
    random = np.random.default_rng(1)
    return {
        "lamp": rg.Emitter([[0, 0, 1], [0, 1, 1], [1, 1, 1], [1, 0, 1]], [1, 2, 3, 2]),
        "screens": [[[0.1 * i, 0, 0.5], [0.1 * i + 0.05, 0, 0.5], [0.1 * i + 0.05, 1, 0.5]] for i in range(10)],
        "x": random.random((2_000_000, 3)) * [1, 1, 0.1],
        "scene": rg.Scene.read(data / "scenes/cornell.obj"),
        "solution": room.solve(error=0.05),
        "places": random.random((2_000_000, 3)) * 0.8 + 0.1,
    }


@pytest.mark.parametrize("call", LONG)
def test_ctrl_c_ends_every_long_call_and_leaves_all_usable(long, call):
    took, result, counted = interrupted(0.5, lambda: LONG[call](long))
    assert isinstance(result, KeyboardInterrupt), "it ended before"
    assert took < 60 and counted > 10
    assert rg.evaluate([0.5, 0.5, 0.0], [0, 0, 1], long["lamp"]).radiosity > 0
