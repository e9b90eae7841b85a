"""Meshes of other libraries, in and out: trimesh, pyvista and meshio, none of which is imported to take one."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Optional

import numpy as np

if TYPE_CHECKING:
    from ._scene import Scene

#: Numbers of VTK's cells that are faces, and in which order their corners stand.
FACES = {5: [0, 1, 2], 7: None, 8: [0, 1, 3, 2], 9: [0, 1, 2, 3]}

#: Those of points and lines, which are left out.
THIN = {0, 1, 2, 3, 4}


@dataclass
class Mesh:
    """Vertices, faces as lists of indices, the surface of each face if it is told, and what was left out."""

    vertices: "list[Any]" = field(default_factory=list)
    faces: "list[Any]" = field(default_factory=list)
    names: "Optional[list[str]]" = None
    notes: "list[str]" = field(default_factory=list)
    count: int = 0

    def add(self, vertices: Any, faces: "list[Any]", names: "Optional[list[str]]" = None) -> None:
        """Adds a part, whose indices are its own."""
        points = np.asarray(vertices, dtype=float).reshape(-1, 3)
        if names is not None:
            self.names = (self.names or [f"face {index}" for index in range(len(self.faces))]) + names
        elif self.names is not None:
            self.names += [f"face {len(self.faces) + index}" for index in range(len(faces))]
        self.faces += [np.asarray(face) + self.count for face in faces] if self.count else faces
        self.vertices.append(points)
        self.count += len(points)


def taken(mesh: Any, names: Any) -> Mesh:
    """Another library's mesh. `names`, if it is a text, is the cell array that has the surface of each face."""
    found, array = Mesh(), names if isinstance(names, str) else None
    _take(found, mesh, array, None)
    if array is not None and found.names is None:
        raise ValueError(f"names is {array!r}: {type(mesh).__name__} has no cell array of this name; it has {_arrays(mesh)}")
    return found


def _arrays(mesh: Any) -> "list[str]":
    return sorted(str(name) for name in (getattr(mesh, "cell_data", None) or {}).keys())


def _take(into: Mesh, mesh: Any, array: Optional[str], name: Optional[str]) -> None:
    if hasattr(mesh, "geometry") and hasattr(mesh, "graph"):  # trimesh.Scene
        for node in sorted(mesh.graph.nodes_geometry):
            transform, geometry = mesh.graph[node]
            part = mesh.geometry[geometry]
            if not hasattr(part, "faces"):
                into.notes.append(f"`{node}` of the mesh has no faces: left out")
                continue
            placed = np.asarray(part.vertices) @ np.asarray(transform)[:3, :3].T + np.asarray(transform)[:3, 3]
            # A reflection turns faces round.
            step = -1 if np.linalg.det(np.asarray(transform)[:3, :3]) < 0 else 1
            into.add(placed, list(np.asarray(part.faces)[:, ::step]), [str(node)] * len(part.faces))
            _note_colours(into, part)
    elif hasattr(mesh, "n_blocks") and hasattr(mesh, "keys"):  # pyvista.MultiBlock
        for index, key in enumerate(mesh.keys()):
            if mesh[index] is not None:
                _take(into, mesh[index], array, str(key) if key is not None else f"block {index}")
    elif hasattr(mesh, "cells") and hasattr(mesh, "cells_dict") and not hasattr(mesh, "celltypes"):  # meshio.Mesh
        _take_meshio(into, mesh, array, name)
    elif hasattr(mesh, "points") and (hasattr(mesh, "celltypes") or hasattr(mesh, "cast_to_unstructured_grid")):
        _take_vtk(into, mesh, array, name)
    elif getattr(mesh, "faces", None) is not None and hasattr(mesh, "vertices"):
        into.add(mesh.vertices, list(mesh.faces), None if name is None else [name] * len(mesh.faces))
        _note_colours(into, mesh)
    else:
        what = "expected two arrays, or a mesh of trimesh, pyvista or meshio"
        raise ValueError(f"{type(mesh).__name__} has no vertices and faces: {what}")


def _note_colours(into: Mesh, mesh: Any) -> None:
    if getattr(getattr(mesh, "visual", None), "kind", None) in ("face", "vertex"):
        into.notes.append("colours of the mesh are not used: give reflectance and emission")


def _take_vtk(into: Mesh, mesh: Any, array: Optional[str], name: Optional[str]) -> None:
    grid = mesh if hasattr(mesh, "celltypes") else mesh.cast_to_unstructured_grid()
    offsets = np.asarray(grid.cell_offsets if hasattr(grid, "cell_offsets") else grid.offset)
    kinds, corners = np.asarray(grid.celltypes), np.asarray(grid.cell_connectivity)
    faces, kept = [], []
    for cell, kind in enumerate(kinds.tolist()):
        if kind in THIN:
            continue
        if kind not in FACES:
            raise ValueError(f"cell {cell} of the mesh is of VTK's kind {kind}, no polygon: pass mesh.extract_surface() or .triangulate()")
        outline, order = corners[offsets[cell] : offsets[cell + 1]], FACES[kind]
        faces.append(outline if order is None else outline[order])
        kept.append(cell)
    if len(kept) < len(kinds):
        into.notes.append(f"{len(kinds) - len(kept)} points and lines of the mesh are left out")
    data = {str(key): np.asarray(mesh.cell_data[key]) for key in mesh.cell_data.keys()}
    into.add(grid.points, faces, _named(data, array, name, kept))
    _note_arrays(into, data)


def _take_meshio(into: Mesh, mesh: Any, array: Optional[str], name: Optional[str]) -> None:
    faces: list[Any] = []
    kept: list[int] = []
    skipped: dict[str, int] = {}
    at = 0
    for block in mesh.cells:
        rows = block.data
        if block.type in ("triangle", "quad") or block.type.startswith("polygon"):
            faces += [np.asarray(row) for row in rows]
            kept += range(at, at + len(rows))
        elif block.type in ("vertex", "line") or block.type.startswith("line"):
            skipped[block.type] = skipped.get(block.type, 0) + len(rows)
        else:
            raise ValueError(f"the mesh has cells of kind {block.type!r}: expected triangle, quad or polygon; take its surface first")
        at += len(rows)
    into.notes.extend(f"{count} cells of kind {kind!r} of the mesh are left out" for kind, count in skipped.items())
    points = np.asarray(mesh.points, dtype=float)
    if points.shape[1] == 2:
        points = np.column_stack([points, np.zeros(len(points))])
    data = {str(key): np.concatenate([np.asarray(part) for part in parts]) for key, parts in mesh.cell_data.items() if len(parts)}
    into.add(points, faces, _named(data, array, name, kept))
    _note_arrays(into, data)


def _named(data: "dict[str, Any]", array: Optional[str], name: Optional[str], kept: "list[int]") -> "Optional[list[str]]":
    if array is not None and array in data:
        return [str(data[array][cell]) for cell in kept]
    return None if name is None else [name] * len(kept)


def _note_arrays(into: Mesh, data: "dict[str, Any]") -> None:
    for key, values in data.items():
        if values.ndim == 2 and values.shape[1] in (3, 4) and (values.dtype == np.uint8 or key.lower() in ("rgb", "rgba", "colors")):
            into.notes.append(f"face colours `{key}` of the mesh are not used: give reflectance and emission")


def _needed(name: str, extra: str) -> Any:
    import importlib

    try:
        return importlib.import_module(name)
    except ImportError:
        raise ImportError(f"this needs {name}: pip install {extra}") from None


def _columns(scene: "Scene") -> "dict[str, Any]":
    """What cells of another library's mesh have: the surface by its number, and reflectance and emission in each channel."""
    order = {name: index for index, name in enumerate(dict.fromkeys(scene.names))}
    columns: "dict[str, Any]" = {"surface_index": np.array([order[name] for name in scene.names], dtype=np.int32)}
    for what, values in (("reflectance", scene.reflectance), ("emission", scene.emission)):
        columns[what] = values[:, 0].copy() if values.shape[1] == 1 else values
    return columns


def to_pyvista(scene: "Scene") -> Any:
    """As `pyvista.PolyData`, a polygon a face."""
    pyvista = _needed("pyvista", "radgrad[vtk]")
    outlines = scene.outlines
    starts = np.cumsum([0] + [len(outline) for outline in outlines])
    faces = np.concatenate([np.r_[len(outline), start : start + len(outline)] for outline, start in zip(outlines, starts)])
    mesh = pyvista.PolyData(np.concatenate(outlines), faces=faces)
    for name, values in {"surface": np.array(scene.names), **_columns(scene)}.items():
        mesh.cell_data[name] = values
    return mesh


def to_meshio(scene: "Scene") -> Any:
    """As `meshio.Mesh`: triangles, then quads, then other polygons."""
    meshio = _needed("meshio", "meshio")
    outlines = scene.outlines
    starts = np.cumsum([0] + [len(outline) for outline in outlines])
    by_size: "dict[int, list[int]]" = {}
    for face, outline in enumerate(outlines):
        by_size.setdefault(len(outline), []).append(face)
    cells, order = [], []
    for size in sorted(by_size):
        kind = {3: "triangle", 4: "quad"}.get(size, f"polygon{size}")
        cells.append((kind, np.array([np.arange(starts[face], starts[face] + size) for face in by_size[size]])))
        order.append(by_size[size])
    data = {name: [values[faces] for faces in order] for name, values in _columns(scene).items()}
    return meshio.Mesh(np.concatenate(outlines), cells, cell_data=data)


def to_trimesh(scene: "Scene") -> Any:
    """As `trimesh.Scene`: a mesh a surface, of triangles."""
    trimesh = _needed("trimesh", "radgrad[mesh]")
    parts: "dict[str, tuple[list[Any], list[Any]]]" = {}
    for name, outline in zip(scene.names, scene.outlines):
        vertices, faces = parts.setdefault(name, ([], []))
        faces += [[len(vertices) + corner for corner in triangle] for triangle in triangles(outline)]
        vertices += list(outline)
    whole = trimesh.Scene()
    for name, (vertices, faces) in parts.items():
        whole.add_geometry(trimesh.Trimesh(np.array(vertices), np.array(faces), process=False), node_name=name, geom_name=name)
    return whole


def triangles(outline: Any) -> "list[list[int]]":
    """A simple polygon in triangles of its corners: ears are cut off, each time the one with the largest least height."""
    points, left, found = np.asarray(outline, dtype=float), list(range(len(outline))), []
    area = 0.5 * sum(np.cross(points[a] - points[0], points[b] - points[0]) for a, b in zip(left[1:], left[2:]))
    normal = area / np.linalg.norm(area)

    def side(a: int, b: int, c: int) -> float:
        return float(np.dot(np.cross(points[b] - points[a], points[c] - points[a]), normal))

    while len(left) > 3:
        best, widest = 0, float("-inf")
        for at in range(len(left)):
            a, b, c = left[at - 1], left[at], left[(at + 1) % len(left)]
            size = side(a, b, c)
            length = max(np.linalg.norm(points[x] - points[y]) for x, y in ((a, b), (b, c), (c, a)))
            inside = (p for p in left if p not in (a, b, c) and min(side(a, b, p), side(b, c, p), side(c, a, p)) >= 0)
            if size / length > widest and not any(inside):
                best, widest = at, float(size / length)
        found.append([left[best - 1], left[best], left[(best + 1) % len(left)]])
        del left[best]
    return [*found, left]
