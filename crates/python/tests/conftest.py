"""What the tests have in common."""

import pathlib

import pytest

#: The project, where the tests run in it.
ROOT = pathlib.Path(__file__).resolve().parents[3]


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
