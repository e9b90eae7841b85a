"""Scenes, factors and solutions."""

import pickle

import numpy as np
import pytest

import radgrad as rg


def test_files_and_their_notes(data):
    scene = rg.Scene.read(data / "scenes/cornell.obj")
    assert len(scene.notes) == 1 and "split" in scene.notes[0] and "cornell.obj:" in scene.notes[0]
    assert scene.channels == ["r", "g", "b"] and "light" in scene.names
    assert scene.check() == []
    assert scene.emission.shape == (len(scene), 3) and scene.emission.max() > 0
    copy = pickle.loads(pickle.dumps(scene))
    assert copy.digest == scene.digest and copy.notes == scene.notes and copy.names == scene.names
    for a, b in zip(copy.outlines, scene.outlines):
        assert np.array_equal(a, b)
    with pytest.raises(ValueError, match="cannot be read"):
        rg.Scene.read(data / "scenes/none.obj")
    with pytest.raises(ValueError, match="give more with|KiB|bytes"):
        rg.Scene.read(data / "scenes/cornell.obj", budget=1000)


def test_arrays_and_what_is_wrong_with_them(room):
    assert room.names == ["floor", "ceiling", "front", "back", "left", "right"] and np.allclose(room.areas, 1)
    assert np.allclose(room.emission[:, 0], [0, 1, 0, 0, 0, 0], rtol=1e-15) and room.check() == []
    v = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0.0]])
    turned = rg.Scene(v, [[0, 1, 2, 3]], emission=1.0)
    assert any("light nothing" in warning or "inside out" in warning for warning in turned.check())
    warped = rg.Scene(v + [[0, 0, 0], [0, 0, 0.2], [0, 0, 0], [0, 0, 0]], [[0, 1, 2, 3]])
    assert len(warped) == 2 and "split into 2 triangles" in warped.notes[0] and "faces[0]" in warped.notes[0]
    colours = rg.Scene(v, [[0, 1, 2], [0, 2, 3]], reflectance=[[0.1, 0.2, 0.3], [0.3, 0.2, 0.1]])
    assert colours.channels == ["r", "g", "b"] and np.allclose(colours.reflectance[1], [0.3, 0.2, 0.1])
    for call, words in [
        (lambda: rg.Scene(v, [[0, 1, 9]]), ["faces[0]", "vertex 9", "there are 4"]),
        (lambda: rg.Scene(v, [[0, 1, -1]]), ["faces[0]", "vertex -1"]),
        (lambda: rg.Scene(v, [[0, 1, 2], [0, 1]]), ["faces[1]", "at least 3 vertices"]),
        (lambda: rg.Scene(v, [[0.0, 1.0, 2.0]]), ["faces[0]", "indices"]),
        (lambda: rg.Scene(v, []), ["at least one face"]),
        (lambda: rg.Scene(v, [[0, 1, 2]], reflectance=1.5), ["reflectance is 1.5", "between 0 and 1"]),
        (lambda: rg.Scene(v, [[0, 1, 2]], emission=-1), ["not negative"]),
        (lambda: rg.Scene(v, [[0, 1, 2]], reflectance=[0.1, 0.2]), ["reflectance has shape (2,)", "(1,)"]),
        (lambda: rg.Scene(v, [[0, 1, 2]], names=["a", "b"]), ["2 names for 1 faces"]),
        (lambda: rg.Scene(object()), ["object has no vertices and faces"]),
    ]:
        with pytest.raises(ValueError) as refusal:
            call()
        assert all(word in str(refusal.value) for word in words), str(refusal.value)
    assert len(rg.Scene(v, [[0, 1, 2], [0, 1, 1]], drop_degenerate=True)) == 1


def test_factors_close_and_are_reciprocal(room):
    F = room.factors()
    assert F.closure < 1e-12 and F.reciprocity < 1e-15 and F.unmet == 0 and F.unclosed == []
    assert F.indptr.shape == (7,) and F.data.shape == F.indices.shape == (30,)
    # Opposite unit squares.
    opposite = F.data[F.indptr[0] : F.indptr[1]][F.indices[F.indptr[0] : F.indptr[1]] == 1]
    assert abs(opposite[0] - 0.199824895698387) < 1e-14
    repaired = F.repaired()
    assert repaired.closure < 1e-14 and repaired.moved[0] < 1e-12
    names, dense = F.by_surface()
    assert names == room.names and np.allclose(dense.sum(1), 1)
    with pytest.raises(ValueError, match="tolerance is -1"):
        room.factors(tolerance=-1)
    with pytest.raises(ValueError, match="closed scene"):
        rg.Scene([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [0, 1, 1], [1, 0, 1]], [[0, 1, 2], [3, 4, 5]]).factors().repaired()


def test_factors_as_sparse_matrices(room):
    scipy = pytest.importorskip("scipy.sparse", reason="scipy is not installed")
    F = room.factors()
    assert isinstance(F.values, scipy.csr_array) and F.values.shape == (6, 6)
    assert (F.lower.data <= F.values.data).all() and (F.values.data <= F.upper.data).all()
    assert np.allclose(F.values.sum(axis=1), 1)


def test_blocks_of_factors_join_to_the_same_bytes(data):
    scene = rg.Scene.read(data / "scenes/two_blocks.obj", need_materials=False)
    whole = scene.factors(tolerance=0.1)
    from radgrad import _radgrad
    from radgrad._factors import Factors, settings_of

    settings = settings_of(0.1, None, None, None, None)
    rows = len(scene._core.row_areas)
    blocks = [scene._core.factor_block(settings, first, min(first + 5, rows)) for first in range(0, rows, 5)]
    blocks = [pickle.loads(pickle.dumps(block)) for block in reversed(blocks)]
    assert Factors(scene, scene._core.join(settings, blocks), settings).tobytes() == whole.tobytes()
    with pytest.raises(ValueError, match="rows"):
        scene._core.join(settings, blocks[1:])
    with pytest.raises(ValueError, match="expected a block of factors"):
        _radgrad.FactorBlock.from_bytes(b"0")


def test_gradients_are_those_of_what_is_gathered(room):
    s = room.solve(error=1e-4)
    places, up = np.array([[0.3, 0.6, 0.0], [0.7, 0.45, 0.0]]), [0, 0, 1]
    found = s.gradient(places, up)
    assert found.radiosity.shape == (2, 1, 3) and found.radiosity_estimate.shape == (2, 1)
    assert np.allclose(found.radiosity, room.reflectance[0, 0] * found.irradiance, rtol=1e-12)
    free = s.gradient(places + [0, 0, 0.4], up)
    assert np.array_equal(free.radiosity, free.irradiance) and np.array_equal(free.radiosity_estimate, free.irradiance_estimate)
    for at, slopes, axes in [(places, found.irradiance, (0, 1)), (places + [0, 0, 0.4], free.irradiance, (0, 1, 2))]:
        for axis in axes:
            step = 1e-3 * np.eye(3)[axis]
            ahead, behind = s.gather(at + step, up).irradiance, s.gather(at - step, up).irradiance
            size = np.linalg.norm(slopes, axis=2)
            assert np.all(np.abs((ahead - behind) / 2e-3 - slopes[:, :, axis]) <= 0.01 * size), (axis, slopes)
    assert np.all(found.irradiance[:, :, 2] == 0) and np.all(found.radiosity_estimate > 0)
    assert s.gradient([0.3, 0.6, 0.0], up).radiosity.shape == (1, 3)
    with pytest.raises(ValueError, match="point 1: "):
        s.gradient([[0.3, 0.6, 0.0], [5, 5, 5]], up, on="face")


def test_a_solved_room(room, tmp_path):
    rounds = []
    s = room.solve(error=0.01, progress=rounds.append)
    assert len(rounds) == s.summary["rounds"] and rounds[-1].estimate <= 0.01 and s.summary["estimate"] <= 0.01
    # In the middle of the floor: more than from the ceiling alone, less than without loss.
    b = s.gather([[0.5, 0.5, 0], [0.25, 0.5, 0]], [0, 0, 1])
    assert b.radiosity.shape == b.estimate.shape == (2, 1) and b.face.tolist() == [0, 0]
    assert np.all(b.radiosity > 0.5 * 0.19) and np.all(b.radiosity < 1)
    with pytest.raises(ValueError, match=r"point 1: "):
        s.gather([[0.5, 0.5, 0], [5, 5, 5]], [0, 0, 1], on="face")
    with pytest.raises(ValueError, match=r"point 0: "):
        s.gather([[0.5, 0.5, 0]], [0, 0, -1])
    # On the floor half of what arrives is sent on; above it, a sensor sees more of the ceiling.
    assert np.allclose(b.radiosity, 0.5 * b.irradiance, rtol=1e-12)
    free = s.gather([[0.5, 0.5, 0.0], [0.5, 0.5, 0.3], [0.5, 0.5, 0.6]], [0, 0, 1])
    assert free.face.tolist() == [0, -1, -1] and np.all(np.diff(free.irradiance[:, 0]) > 0)
    assert np.array_equal(free.radiosity[1:], free.irradiance[1:]) and np.all(free.irradiance_estimate < 0.05)
    picture = s.image(([0.5, 0.1, 0.5], [0.5, 1, 0.5], [0, 0, 1], 60), size=(24, 16), file=tmp_path / "room.exr")
    assert picture.radiosity.shape == picture.estimate.shape == (16, 24, 1) and picture.radiosity.max() > 0.1
    assert (tmp_path / "room.exr").stat().st_size > 16 * 24 * 4
    with pytest.raises(ValueError, match="eye and target"):
        s.image(([0, 0, 0], [0, 0, 0], [0, 0, 1], 60))
    with pytest.raises(ValueError, match="vtu"):
        s.to_vtu(tmp_path / "room.txt")
    with pytest.raises(OSError, match="cannot be written"):
        s.to_vtu(tmp_path / "none/room.vtu")
    copy = pickle.loads(pickle.dumps(s))
    assert copy.digest == s.digest and np.array_equal(copy.gather([0.5, 0.5, 0], [0, 0, 1]).radiosity, s.gather([0.5, 0.5, 0], [0, 0, 1]).radiosity)


def test_a_closed_white_room_is_refused_and_an_open_one_solved(room):
    white = rg.Scene(np.concatenate(room.outlines), np.arange(24).reshape(6, 4), reflectance=1.0, emission=[0, 1, 0, 0, 0, 0])
    with pytest.raises(ValueError, match="reflectance below 1"):
        white.solve()
    open_room = rg.Scene(np.concatenate(room.outlines[:5]), np.arange(20).reshape(5, 4), reflectance=1.0, emission=[0, 1, 0, 0, 0])
    assert 0 < open_room.solve(error=0.05).summary["estimate"] < 1
    assert white.capped(0.9).solve(error=0.05).summary["elements"] > 0
    for wrong in ({"error": 0}, {"divide": "x"}, {"degree": 9}, {"seconds": -1}):
        with pytest.raises(ValueError):
            room.solve(**wrong)


def test_what_a_callback_raises_comes_out(room):
    def raises(_):
        raise LookupError("enough")

    with pytest.raises(LookupError, match="enough"):
        room.solve(error=0.01, progress=raises)


def test_a_solution_is_certified_by_the_scene_alone(room, tmp_path):
    s = room.solve(error=0.02)
    assert "confidence" not in s.summary
    lower, upper = s.certified[0]
    assert s.certified.shape == (1, 2) and s.confidence == 1e-6 and s.summary["confidence"] == 1e-6
    assert lower < s.summary["channels"][0]["mean"] < upper and s.summary["channels"][0]["certified"] == [lower, upper]
    wide = s.certify(width=0.1, delta=1e-3, seed=3)
    assert (wide.confidence, wide.seed) == (1e-3, 3) and np.array_equal(s.certified, wide.interval)
    assert np.array_equal(s.certify(width=0.1, delta=1e-3, seed=3).interval, wide.interval)
    s.to_vtu(tmp_path / "room.vtu")
    assert "certified" in (tmp_path / "room.vtu").read_text()
    points = ([[0.5, 0.5, 0.0], [0.5, 0.5, 0.5]], [0, 0, 1])
    of, b = s.certify(width=0.05, points=points, rays=50_000), s.gather(*points)
    assert of.interval.shape == of.irradiance.shape == (2, 1, 2)
    assert np.all(of.interval[..., 0] <= b.radiosity + b.estimate) and np.all(b.radiosity - b.estimate <= of.interval[..., 1])
    # On the floor half of what arrives is sent on; in space all is meant.
    assert np.allclose(of.interval[0], 0.5 * of.irradiance[0], rtol=1e-12) and np.array_equal(of.interval[1], of.irradiance[1])
    for wrong in ({"width": 0.0}, {"delta": 1.0}, {"points": ([[5, 5, 0.0]], [0, 0, 0])}):
        with pytest.raises(ValueError):
            s.certify(**wrong)


def test_derivatives_by_materials_are_differences():
    v = np.array([[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)], dtype=float)
    f = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    names = ["floor", "ceiling", "south", "north", "west", "east"]
    rho, lit = np.array([0.3, 0.7, 0.5, 0.5, 0.6, 0.4]), np.array([0.0, 1.0, 0.0, 0.0, 0.0, 0.0])
    points = ([[0.3, 0.4, 0.0], [0.5, 0.5, 0.5]], [[0, 0, 1], [0, 0, 1]])

    def of(rho, lit):
        s = rg.Scene(v, f, reflectance=rho, emission=lit, names=names).solve(error=1e-4)
        return s.derivative({"floor": 2.0, "west": 1.0}), s.derivative([1.0, 0.5], points=points)

    base = of(rho, lit)
    for face in (0, 4):
        step = np.eye(6)[face]
        up, down, brighter = of(rho + 0.05 * step, lit), of(rho - 0.05 * step, lit), of(rho, lit + step)
        for d, a, b, c in zip(base, up, down, brighter):
            assert d.reflectance.shape == d.emission_estimate.shape == (6, 1)
            assert np.allclose(d.reflectance[face], (a.value - b.value) / 0.1, rtol=0.005, atol=0.002)
            assert np.allclose(d.emission[face], c.value - d.value, rtol=0.005, atol=0.002)
    rough = rg.Scene(v, f, reflectance=rho, emission=lit, names=names).solve(error=0.5)
    with pytest.raises(ValueError, match="no surface is called 'wall'"):
        rough.derivative({"wall": 1.0})
    # Positions without normals, three arrays, one point with no axis, and none.
    for wrong in (points[0][:1], (*points, points[0]), ([0.5, 0.5, 0.5], [0, 0, 1]), 3.0):
        with pytest.raises(ValueError, match="points"):
            rough.derivative([1.0], points=wrong)


def test_derivatives_by_vertices_follow_motions_of_faces():
    v = [[0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0], [0.5, 0.5, 1], [0.5, 1, 1], [1.2, 1, 1], [1.2, 0.5, 1]]
    f, about = [[0, 1, 2, 3], [4, 5, 6, 7]], np.array([0.85, 0.75, 1.0])

    def solved(lamp):
        return rg.Scene(np.array([*v[:4], *lamp]), f, reflectance=[0.5, 0.0], emission=[0, 10], names=["floor", "lamp"]).solve(error=1e-4)

    lamp = np.array(v[4:], dtype=float)
    d = solved(lamp).derivative({"floor": 1.0}, vertices=True)
    assert [by.shape for by in d.vertices] == [(4, 1, 3)] * 2 and [of.shape for of in d.vertices_estimate] == [(4, 1)] * 2
    slopes = [d.translation([1])[0, 2], d.rotation([1], about)[0, 0], d.scale([1], about)[0]]
    arms = lamp - about
    motions = [np.tile([0, 0, 1.0], (4, 1)), np.cross([1.0, 0, 0], arms), arms]
    for slope, motion in zip(slopes, motions):
        ahead, behind = (solved(lamp + step * motion).derivative({"floor": 1.0}).value[0] for step in (0.01, -0.01))
        assert abs(slope - (ahead - behind) / 0.02) < 0.01 * d.value[0]
    # All together turns nothing.
    assert np.allclose(d.translation([0, 1]), 0.0, atol=1e-9)
    with pytest.raises(ValueError, match="vertices=True"):
        solved(lamp).derivative({"floor": 1.0}).scale([1], about)
