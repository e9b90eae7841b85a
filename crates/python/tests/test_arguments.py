"""Wrong arguments are named, with the rule and what to do; what was asked for and not reached is a warning; all have a repr."""

import pickle
import warnings

import numpy as np
import pytest

import radgrad as rg

LAMP = rg.Emitter([[0, 0, 1], [0, 1, 1], [1, 1, 1], [1, 0, 1]])
UP, X = [0, 0, 1], [0.5, 0.5, 0.0]
SQUARE = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0.0]]
MASKED = np.ma.masked_array([[0.5, 0.5, 0.0]], mask=[[False, True, False]])


@pytest.mark.parametrize(
    "name, call",
    [
        ("x", lambda room, value: rg.evaluate(value, UP, LAMP)),
        ("normal", lambda room, value: rg.evaluate(X, value, LAMP)),
        ("x", lambda room, value: rg.hessian(value, UP, LAMP)),
        ("x", lambda room, value: rg.irradiance_vector(value, UP, LAMP)),
        ("x", lambda room, value: rg.derivatives(value, UP, LAMP)),
        ("about", lambda room, value: rg.derivatives(X, UP, LAMP).scale(value)),
        ("x", lambda room, value: rg.EmitterTree([LAMP]).total(value, UP, atol=1e-3)),
        ("vertices", lambda room, value: rg.Emitter(value)),
        ("vertices", lambda room, value: rg.Scene(value, [[0, 1, 2]])),
        ("points", lambda room, value: room.solve(error=0.1).gather(value, UP)),
        ("normals", lambda room, value: room.solve(error=0.1).gather(X, value)),
    ],
)
def test_masked_and_complex_arrays_are_refused_by_name(room, name, call):
    with pytest.raises(ValueError, match=f"^{name} is a masked array.*{name}.filled"):
        call(room, MASKED)
    with pytest.raises(ValueError, match=f"^{name} is complex.*{name}.real"):
        call(room, np.array([[0.5, 0.5, 0.0]]) + 0j)
    with pytest.raises(ValueError, match=f"^{name}: expected numbers, found an array of"):
        call(room, np.array([["0.5", "0.5", "0"]]))


@pytest.mark.parametrize(
    "words, call",
    [
        ("^reflectance is a masked", lambda room: rg.Scene(SQUARE, [[0, 1, 2]], reflectance=np.ma.masked_array([0.5], mask=[True]))),
        ("^emission is complex", lambda room: rg.Scene(SQUARE, [[0, 1, 2]], emission=1j)),
        (r"faces\[0\] is a masked", lambda room: rg.Scene(SQUARE, [np.ma.masked_array([0, 1, 2], mask=[0, 0, 1])])),
        ("^emission is complex", lambda room: rg.Emitter(SQUARE, [1, 2, 3, 4j])),
        ("^emission has shape", lambda room: room.replaced(emission=[1.0, 2.0])),
        ("^reflectance is a masked", lambda room: room.replaced(reflectance=np.ma.ones(6))),
        ("between 0 and 1", lambda room: room.replaced(reflectance=1.5)),
        ("^q has shape", lambda room: room.factors() @ [1.0, 2.0]),
        ("^q is complex", lambda room: room.factors() @ np.full(6, 1j)),
        ("^tolerance is -1.*0 asks", lambda room: room.factors(tolerance=-1)),
        ("^tolerance is complex", lambda room: room.factors(tolerance=1j)),
        ("^most_cells is 1.5", lambda room: room.factors(most_cells=1.5)),
        ("^error: expected numbers", lambda room: room.solve(error="small")),
        ("^progress is 7", lambda room: room.solve(progress=7)),
        ("^progress is 7", lambda room: room.factors(tolerance=0.3, progress=7)),
        ("^gradient: expected three numbers", lambda room: rg.Affine(1.0, [1.0, 2.0])),
        ("^origin: expected three numbers", lambda room: rg.Polynomial([0.0], [(1.0, (0, 0, 0))])),
        ("^terms: .*whole and from 0 to 255", lambda room: rg.Polynomial([0.0] * 3, [(1.0, (0, -1, 0))])),
        ("off the plane .*triangles, or .*precision", lambda room: rg.Emitter([*SQUARE[:3], [0, 1, 0.1]])),
        ("^digits is nan", lambda room: rg.digits(X, UP, LAMP, digits=np.nan)),
        ("^count is 'a'", lambda room: rg.threads("a")),
        (r"^faces\[0\] is .*astype\(int\)", lambda room: rg.Scene(SQUARE, [[0.0, 1.0, 2.0]])),
        ("^rtol has shape", lambda room: rg.evaluate(X, UP, LAMP, rtol=[1e-3, 1e-4])),
        ("^precision", lambda room: rg.Scene(SQUARE, [[0, 1, 2]], precision="mm")),
        ("^width is complex", lambda room: room.solve(error=0.1).certify(width=1j)),
    ],
)
def test_an_argument_is_named_with_its_rule(room, words, call):
    with pytest.raises(ValueError, match=words):
        call(room)


@pytest.mark.parametrize(
    "words, call",
    [
        ("^emitters is NoneType: expected a list", lambda: rg.evaluate(X, UP, None)),
        ("^occluders is NoneType: expected a list", lambda: rg.derivatives(X, UP, LAMP, None)),
        ("^function is int", lambda: rg.audit(3, cases=1)),
    ],
)
def test_what_is_of_another_type_is_named(words, call):
    with pytest.raises(TypeError, match=words):
        call()


def test_replaced_values_keep_factors_and_change_the_light(room, monkeypatch):
    F = room.factors()
    darker = room.replaced(reflectance=0.25)
    assert darker.names == room.names and np.all(darker.reflectance == 0.25) and np.array_equal(darker.emission, room.emission)
    with monkeypatch.context() as patch:
        patch.setattr("radgrad._scene.watching", lambda *_: pytest.fail("factors were computed again"))
        again = darker.factors()
    assert again.tobytes() == F.tobytes() and again.scene is darker and again != F
    assert darker.solve(error=0.01).summary["channels"][0]["mean"] < room.solve(error=0.01).summary["channels"][0]["mean"]
    lit = room.replaced(emission=[1, 0, 0, 0, 0, 0])
    assert np.allclose(lit.emission[:, 0], [1, 0, 0, 0, 0, 0]) and np.array_equal(lit.reflectance, room.reflectance)
    assert pickle.loads(pickle.dumps(darker)) == darker != room


def test_factors_are_a_matrix(room):
    F = room.factors()
    q = np.arange(6.0)
    dense = np.asarray(F)
    assert F.shape == (6, 6) and len(F) == 6 and np.allclose(F @ q, dense @ q, rtol=1e-15)
    assert np.allclose(F @ np.eye(6), dense) and F[0, 1] == dense[0, 1] and F[0, 0] == 0 and F[-6, 1] == dense[0, 1]
    rows = F.rows
    assert rows.names == room.names and np.allclose(rows.sum, 1) and np.allclose(rows.open, 0, atol=1e-12)
    assert np.all(rows.lower <= rows.sum) and np.all(rows.sum <= rows.upper)
    assert F.indices.dtype == np.int32
    with pytest.raises(IndexError, match="6 faces"):
        F[0, 6]
    with pytest.raises(TypeError, match="np.asarray"):
        F[0]
    with pytest.raises(ValueError):
        F.data[0] = 2.0


def test_an_open_scene_says_how_much_of_a_view_is_open():
    scene = rg.Scene([*SQUARE, *([x, y, 1.0] for x, y, _ in SQUARE)], [[0, 1, 2, 3], [7, 6, 5, 4]], names=["low", "high"])
    F = scene.factors()
    assert np.allclose(F.rows.open, 1 - 0.199824895698387) and np.array_equal(F @ [0.0, 1.0], [F[0, 1], 0.0])
    # A face that sees nothing has an empty row.
    alone = rg.Scene(SQUARE, [[0, 1, 2, 3]]).factors()
    assert np.array_equal(alone @ [5.0], [0.0])


def test_what_was_missed_is_a_warning(data):
    scene = rg.Scene.read(data / "scenes/two_blocks.obj", need_materials=False)
    with pytest.warns(rg.ToleranceWarning, match="factors have a bound above.*most_cells"):
        scene.factors(tolerance=1e-6, most_cells=10, most_points=100)
    lit = rg.Scene.read(data / "scenes/two_blocks.obj")
    with pytest.warns(rg.ToleranceWarning, match="estimate is .*above the error of 1e-05"):
        lit.solve(error=1e-5, most_elements=1)


def test_what_a_reader_changed_is_a_warning_and_what_was_met_is_none(data, room):
    with pytest.warns(rg.ReaderWarning, match="cornell.obj.*split"):
        rg.Scene.read(data / "scenes/cornell.obj")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        room.factors()
        room.solve(error=0.05)


def test_progress_is_told_of_long_work(data):
    scene, steps = rg.Scene.read(data / "scenes/two_blocks.obj", need_materials=False), []
    scene.factors(tolerance=0.02, progress=steps.append)
    assert steps and all(isinstance(step, rg.Step) and 0 <= step.done <= step.all for step in steps)
    assert steps[-1].done == steps[-1].all > 0

    def raises(_):
        raise LookupError("enough")

    with pytest.raises(LookupError, match="enough"):
        scene.factors(tolerance=0.01, progress=raises)


def test_progress_is_a_line_where_that_is_asked(data, capsys):
    scene = rg.Scene.read(data / "scenes/two_blocks.obj", need_materials=False)
    scene.factors(tolerance=0.021, progress=True)
    assert "factors: rows" in capsys.readouterr().err
    scene.factors(tolerance=0.022, progress=False)
    scene.factors(tolerance=0.023)
    assert capsys.readouterr().err == ""


def everything(room):
    solution = room.solve(error=0.05)
    x = np.array([[0.5, 0.5, 0.0], [0.2, 0.5, 0.0]])
    return {
        "Scene": room,
        "Factors": room.factors(),
        "Rows": room.factors().rows,
        "Solution": solution,
        "Gathered": solution.gather(x, UP),
        "Slopes": solution.gradient(x, UP),
        "Certificate": solution.certify(width=0.3),
        "Answer": rg.evaluate(x, UP, LAMP),
        "Hessian": rg.hessian(x, UP, LAMP),
        "Derivatives": rg.derivatives(x, UP, LAMP, [SQUARE]),
        "Total": rg.EmitterTree([LAMP]).total(x, UP, atol=1e-3),
        "Emitter": LAMP,
        "AuditReport": rg.verify(cases=6, families=["far"]),
        "Heat": rg.heat([[0, 1], [1, 0]], 0.5, T=[300, 400]),
    }


def test_all_have_a_repr_a_table_and_equality(room):
    one, other = everything(room), everything(room)
    for kind, of in one.items():
        assert kind in repr(of) and "object at" not in repr(of), kind
        assert of._repr_html_().startswith("<table>"), kind
        assert of == other[kind] and not of != other[kind] and of != 1, kind
        assert pickle.loads(pickle.dumps(of)) == of, kind


def test_names_in_tables_are_escaped():
    scene = rg.Scene(SQUARE, [[0, 1, 2, 3]], names=["<script>"])
    assert "<script>" not in scene._repr_html_() and "&lt;script&gt;" in scene._repr_html_()


def test_frames_have_names_and_rows(room):
    pytest.importorskip("pandas", reason="pandas is not installed")
    F = room.factors()
    frame = F.frame()
    assert list(frame.index) == room.names and np.isclose(frame.loc["floor", "ceiling"], F[0, 1])
    solution = room.solve(error=0.05)
    assert list(solution.frame().index) == room.names and solution.frame().loc["floor", "area"] == 1
    assert len(solution.gather([[0.5, 0.5, 0.0]] * 3, UP).frame()) == 3
    assert list(rg.evaluate([X, X], UP, LAMP).frame().columns)[:2] == ["radiosity", "radiosity_error"]
    assert set(rg.verify(cases=6, families=["far"]).frame()["family"]) == {"far"}
    assert np.isclose(solution.by_surface()["floor"][0], solution.frame().loc["floor", "mean_grey"])
