"""Meshes of pyvista, meshio and trimesh, in and out, with names."""

import numpy as np
import pytest

import radgrad as rg

CORNERS = np.array([[x, y, z] for z in (0.0, 1.0) for y in (0.0, 1.0) for x in (0.0, 1.0)])
QUADS = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
NAMES = ["floor", "ceiling", "front", "back", "left", "right"]


def needed(name):
    return pytest.importorskip(name, reason=f"{name} is not installed")


def grid_of(kinds=None, cells=None):
    pyvista = needed("pyvista")
    cells = QUADS if cells is None else cells
    kinds = [9] * len(cells) if kinds is None else kinds
    grid = pyvista.UnstructuredGrid(np.concatenate([[len(cell), *cell] for cell in cells]), np.array(kinds), CORNERS)
    return grid


def test_an_unstructured_grid_has_its_surfaces_by_a_cell_array(room):
    grid = grid_of()
    grid.cell_data["surface"] = NAMES
    scene = rg.Scene(grid, emission=[0, 1, 0, 0, 0, 0], names="surface")
    assert scene.names == NAMES and scene.factors().tobytes() == room.factors().tobytes()


def test_numbers_of_regions_are_names():
    grid = grid_of()
    grid.cell_data["region"] = np.array([0, 1, 2, 2, 2, 2])
    assert rg.Scene(grid, names="region").names == ["0", "1", "2", "2", "2", "2"]


def test_a_cell_array_that_is_not_there_is_named_with_those_that_are():
    grid = grid_of()
    grid.cell_data["part"] = NAMES
    with pytest.raises(ValueError, match="'surface'.*part"):
        rg.Scene(grid, names="surface")


def test_pixels_are_turned_and_lines_left_out_with_a_note():
    grid = grid_of([8, 9, 3], [[0, 1, 2, 3], QUADS[1], [0, 1]])
    with pytest.warns(rg.ReaderWarning, match="1 points and lines"):
        scene = rg.Scene(grid)
    assert len(scene) == 2 and np.allclose(scene.areas, 1)


def test_solid_cells_are_refused_with_what_to_do():
    with pytest.raises(ValueError, match="extract_surface"):
        rg.Scene(grid_of([12], [[0, 1, 3, 2, 4, 5, 7, 6]]))


def test_a_structured_grid_is_a_scene():
    pyvista = needed("pyvista")
    x, y = np.meshgrid(np.linspace(0, 1, 4), np.linspace(0, 1, 3), indexing="ij")
    scene = rg.Scene(pyvista.StructuredGrid(x, y, np.zeros_like(x)))
    assert len(scene) == 6 and np.isclose(scene.areas.sum(), 1)


def test_blocks_are_surfaces():
    pyvista = needed("pyvista")
    blocks = pyvista.MultiBlock({"floor": pyvista.Plane(i_resolution=2, j_resolution=1), "lid": pyvista.Plane(center=(0, 0, 1))})
    scene = rg.Scene(blocks)
    assert set(scene.names) == {"floor", "lid"} and scene.names.count("floor") == 2


def test_face_colours_are_noted():
    grid = grid_of()
    grid.cell_data["rgb"] = np.zeros((6, 3), dtype=np.uint8)
    with pytest.warns(rg.ReaderWarning, match="colours `rgb`"):
        assert "reflectance" in rg.Scene(grid).notes[0]


def test_meshio_comes_and_goes(room):
    meshio = needed("meshio")
    mesh = meshio.Mesh(CORNERS, [("quad", np.array(QUADS))], cell_data={"surface": [np.array(NAMES)]})
    scene = rg.Scene(mesh, emission=[0, 1, 0, 0, 0, 0], names="surface")
    assert scene.names == NAMES and scene.factors().tobytes() == room.factors().tobytes()
    out = scene.to_meshio()
    assert out.cells[0].type == "quad" and np.allclose(out.cell_data["emission"][0], scene.emission[:, 0])
    assert rg.Scene(out).factors().tobytes() == room.factors().tobytes()
    with pytest.raises(ValueError, match="'tetra'"):
        rg.Scene(meshio.Mesh(CORNERS, [("tetra", np.array([[0, 1, 2, 4]]))]))


def test_a_scene_of_trimesh_has_its_nodes_as_surfaces():
    trimesh = needed("trimesh")
    box = trimesh.creation.box()
    box.invert()
    parts = trimesh.Scene()
    parts.add_geometry(box, node_name="room", geom_name="box")
    mirrored = np.diag([-1.0, 1, 1, 1])
    mirrored[:3, 3] = [5, 0, 0]
    parts.add_geometry(box, node_name="mirrored", geom_name="box", transform=mirrored)
    scene = rg.Scene(parts, emission=1.0)
    assert set(scene.names) == {"room", "mirrored"} and len(scene) == 24
    # Each closed and seen from inside, the mirrored one too.
    assert scene.factors().closure < 1e-12
    out = scene.to_trimesh()
    assert set(out.graph.nodes_geometry) == {"room", "mirrored"} and rg.Scene(out).factors().closure < 1e-12


def test_a_scene_goes_to_pyvista_and_back(room):
    needed("pyvista")
    mesh = room.to_pyvista()
    assert mesh.n_cells == 6 and list(mesh.cell_data["surface"]) == NAMES
    again = rg.Scene(mesh, reflectance=mesh.cell_data["reflectance"], emission=mesh.cell_data["emission"], names="surface")
    assert again.names == room.names and again.factors().tobytes() == room.factors().tobytes()


def test_a_solution_goes_to_pyvista(room):
    needed("pyvista")
    solution = room.solve(error=0.05)
    grid = solution.to_pyvista()
    assert grid.n_cells == solution.summary["elements"] and "radiosity" in grid.point_data


def test_polygons_are_cut_into_triangles_of_their_area():
    from radgrad._mesh import triangles

    outlines = [
        [[0, 0], [1, 0], [1, 1], [0, 1]],
        [[0, 0], [4, 0], [4, 4], [3, 4], [3, 1], [1, 1], [1, 4], [0, 4]],
        [[0, 0], [2, 0], [2, 2], [1, 0.2]],
        [[np.cos(a), np.sin(a)] for a in np.linspace(0, 2 * np.pi, 17)[:-1]],
        [[(1 + k % 2) * np.cos(a), (1 + k % 2) * np.sin(a)] for k, a in enumerate(np.linspace(0, 2 * np.pi, 11)[:-1])],
    ]
    for outline in outlines:
        x, y = np.array(outline, dtype=float).T
        area = 0.5 * np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))
        points = np.column_stack([x, y, np.full(len(x), 0.5)])
        parts = triangles(points)
        sizes = [0.5 * np.cross(points[b] - points[a], points[c] - points[a])[2] for a, b, c in parts]
        assert len(parts) == len(outline) - 2 and min(sizes) > 0 and np.isclose(sum(sizes), area)


def test_what_is_no_mesh_is_refused():
    with pytest.raises(ValueError, match="list has no vertices and faces.*trimesh, pyvista or meshio"):
        rg.Scene([[0, 0, 0]])
    with pytest.raises(ValueError, match="names is 'surface'.*list of 1 names"):
        rg.Scene(CORNERS, [[0, 1, 3]], names="surface")
