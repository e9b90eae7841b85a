"""Others read what we write, and we take what others have."""

import subprocess
import sys

import numpy as np
import pytest

import radgrad as rg


@pytest.fixture(scope="module")
def solved(room):
    return room.solve(error=0.02)


def test_pyvista_and_meshio_read_the_vtu(solved, tmp_path):
    file = tmp_path / "room.vtu"
    solved.to_vtu(file)
    pyvista = pytest.importorskip("pyvista", reason="pyvista is not installed")
    grid = pyvista.read(file)
    assert grid.n_cells == solved.summary["elements"]
    names = [name for name in grid.point_data if "radiosity" in name]
    assert names and np.all(np.isfinite(grid.point_data[names[0]]))
    meshio = pytest.importorskip("meshio", reason="meshio is not installed")
    mesh = meshio.read(file)
    assert sum(len(block.data) for block in mesh.cells) == grid.n_cells


def test_trimesh_reads_the_ply_and_gives_its_meshes(solved, tmp_path):
    trimesh = pytest.importorskip("trimesh", reason="trimesh is not installed")
    file = tmp_path / "room.ply"
    solved.to_ply(file)
    assert len(trimesh.load(file, process=False).faces) >= solved.summary["elements"]
    box = trimesh.creation.box()
    box.invert()
    scene = rg.Scene(box, emission=1.0)
    assert len(scene) == 12 and scene.factors().closure < 1e-12


def test_a_mesh_of_pyvista_is_a_scene():
    pyvista = pytest.importorskip("pyvista", reason="pyvista is not installed")
    scene = rg.Scene(pyvista.Cube().flip_faces() if hasattr(pyvista.PolyData, "flip_faces") else pyvista.Cube())
    assert len(scene) == 6 and np.allclose(scene.areas, 1)


def test_openexr_reads_the_picture(solved, tmp_path):
    OpenEXR = pytest.importorskip("OpenEXR", reason="OpenEXR is not installed")
    file = tmp_path / "room.exr"
    picture = solved.image(([0.5, 0.1, 0.5], [0.5, 1, 0.5], [0, 0, 1], 60), size=(20, 10), file=file)
    with OpenEXR.File(str(file), separate_channels=True) as read:
        channels = read.channels()
        assert np.array_equal(channels["grey"].pixels, picture.radiosity[..., 0].astype(np.float32))


def test_pandas_reads_the_tables(data, tmp_path):
    pandas = pytest.importorskip("pandas", reason="pandas is not installed")
    import io

    report = rg.verify(cases=20, families=["generic", "far"])
    table = pandas.read_csv(io.StringIO(report.csv("figures")))
    assert set(table["family"]) == {"generic", "far"} and (table["worst"] >= 0).all()
    factors = tmp_path / "factors.csv"
    scene = data / "scenes/two_blocks.obj"
    command = [sys.executable, "-m", "radgrad._program", "factors", str(scene), "--tolerance", "0.1", "--out", str(factors)]
    subprocess.run(command, check=True, capture_output=True)
    assert len(pandas.read_csv(factors)) > 10


def test_the_program_is_in_the_wheel():
    shown = subprocess.run([sys.executable, "-m", "radgrad._program", "--version"], capture_output=True, text=True, check=True)
    assert shown.stdout.startswith("radgrad ")
    assert subprocess.run([sys.executable, "-m", "radgrad._program", "evil"], capture_output=True).returncode == 2
