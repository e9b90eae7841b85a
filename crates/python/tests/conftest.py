"""What the tests have in common."""

import contextlib
import pathlib
import threading
import time

import pytest

#: The project, where the tests run in it.
ROOT = pathlib.Path(__file__).resolve().parents[3]


@contextlib.contextmanager
def counting():
    """Another thread that counts, as long as Python's lock is free; its count, in a list."""
    counted, done = [0], threading.Event()

    def count():
        while not done.is_set():
            counted[0] += 1
            time.sleep(0.001)

    other = threading.Thread(target=count)
    other.start()
    try:
        yield counted
    finally:
        done.set()
        other.join()


@pytest.fixture(scope="session")
def data() -> pathlib.Path:
    """The project's data folder."""
    return ROOT / "data"


@pytest.fixture(scope="session")
def room():
    """A unit cube seen from inside, with an emitting ceiling."""
    import radgrad as rg

    vertices = [[x, y, z] for z in (0.0, 1.0) for y in (0.0, 1.0) for x in (0.0, 1.0)]
    faces = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    names = ["floor", "ceiling", "front", "back", "left", "right"]
    return rg.Scene(vertices, faces, reflectance=0.5, emission=[0, 1, 0, 0, 0, 0], names=names)
