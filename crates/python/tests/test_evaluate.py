"""Points and emitters."""

import json
import pickle
from decimal import Decimal, localcontext

import numpy as np
import pytest

import radgrad as rg

SQUARE = [[0, 0, 1], [0, 1, 1], [1, 1, 1], [1, 0, 1]]
UP = [0, 0, 1]


def test_the_example_of_the_interface():
    lamp = rg.Emitter(SQUARE, [1, 2, 3, 2])
    x = np.column_stack([np.random.rand(100_000, 2), np.zeros(100_000)])
    a = rg.evaluate(x, [0, 0, 1], lamp, occluders=[], reflectance=1.0, rtol=1e-12)
    assert a.radiosity.shape == a.radiosity_error.shape == a.gradient_error.shape == a.method.shape == (100_000,)
    assert a.gradient.shape == (100_000, 3)
    assert set(a.method) <= set(rg.METHODS)
    assert np.all(a.radiosity_error <= 1e-12 * a.radiosity)
    assert np.all(a.gradient_error <= 1e-12 * np.linalg.norm(a.gradient, axis=1))
    truth = rg.digits(x[0], [0, 0, 1], lamp, digits=50)
    assert isinstance(truth.radiosity, Decimal) and len(truth.gradient) == 3
    assert truth.error <= Decimal("1e-50") * truth.radiosity
    assert abs(truth.radiosity - Decimal(float(a.radiosity[0]))) <= Decimal(float(a.radiosity_error[0]))


def test_the_public_cases_are_inside_their_bounds(data):
    lines = (data / "reference/public.jsonl").read_text().splitlines()
    assert len(lines) == 84
    for line in lines:
        case = json.loads(line)
        emission = case["emitter"]["emission"]
        if "constant" in emission:
            emission = emission["constant"]
        elif "vertex_values" in emission:
            emission = emission["vertex_values"]
        else:
            (emission,) = [
                value if isinstance(value, list) else rg.Affine(value["value"], value["gradient"]) for value in emission.values()
            ]
        lamp = rg.Emitter(case["emitter"]["vertices"], emission)
        receiver = case["receiver"]
        a = rg.evaluate(receiver["position"], receiver["normal"], lamp, case["occluders"], receiver["reflectance"])
        with localcontext() as context:
            context.prec = 60
            value = Decimal(case["truth"]["radiosity"])
            # The truth has thirty digits.
            off = abs(Decimal(float(a.radiosity)) - value) - abs(value) * Decimal("1e-29")
            assert off <= Decimal(float(a.radiosity_error)), case["id"]
            gradient = [Decimal(g) for g in case["truth"]["gradient"]]
            size = sum(g * g for g in gradient).sqrt()
            off = sum((Decimal(float(g)) - h) ** 2 for g, h in zip(a.gradient, gradient)).sqrt() - size * Decimal("1e-29")
            assert off <= Decimal(float(a.gradient_error)), case["id"]


def test_shapes_broadcast():
    lamp = rg.Emitter(SQUARE, 2.0)
    x = np.zeros((4, 1, 3))
    x[:, 0, 0] = np.linspace(0, 1, 4)
    normals = np.array([[0, 0, 1], [0, 1, 1], [1, 0, 2.0]])
    a = rg.evaluate(x, normals, lamp, reflectance=np.array([0.2, 0.4, 0.8]))
    assert a.radiosity.shape == (4, 3) and a.gradient.shape == (4, 3, 3)
    alone = rg.evaluate(x[2, 0], normals[1], lamp, reflectance=0.4)
    assert alone.radiosity.shape == () and alone.gradient.shape == (3,)
    assert alone.radiosity == a.radiosity[2, 1] and np.array_equal(alone.gradient, a.gradient[2, 1])
    assert rg.evaluate(np.zeros((0, 3)), UP, lamp).gradient.shape == (0, 3)
    assert rg.evaluate([0, 0, 0], normals, lamp).radiosity.shape == (3,)


def test_arrays_in_any_order_of_memory_are_taken():
    lamp, x = rg.Emitter(SQUARE), np.random.default_rng(6).random((50, 3)) * 0.9
    usual = rg.evaluate(x, UP, lamp).radiosity
    shifted = np.frombuffer(b"_" + x.tobytes(), dtype=np.float64, offset=1).reshape(50, 3)
    assert not shifted.flags.aligned
    for same in (shifted, np.asfortranarray(x), np.repeat(x, 2, axis=0)[::2], x[::-1].copy()[::-1], x.tolist()):
        assert np.array_equal(rg.evaluate(same, UP, lamp).radiosity, usual)
    frozen = x.copy()
    frozen.setflags(write=False)
    assert np.array_equal(rg.evaluate(frozen, UP, lamp).radiosity, usual)


def test_lists_of_emitters_add_up():
    lamps = [rg.Emitter(SQUARE, 1.0), rg.Emitter([[0, 0, 2], [0, 1, 2], [1, 0, 2]], [1, 2, 3])]
    x = np.random.default_rng(1).random((300, 3)) * [1, 1, 0.5]
    whole, parts = rg.evaluate(x, UP, lamps), [rg.evaluate(x, UP, lamp) for lamp in lamps]
    assert np.allclose(whole.radiosity, sum(p.radiosity for p in parts), rtol=1e-15)
    assert np.all(whole.radiosity_error >= sum(p.radiosity_error for p in parts))
    assert np.allclose(whole.gradient, sum(p.gradient for p in parts), rtol=1e-14, atol=1e-16)
    one_by_one = rg.each(x, UP, lamps)
    assert one_by_one.radiosity.shape == (300, 2) and one_by_one.gradient.shape == (300, 2, 3)
    error = one_by_one.radiosity_error.sum(1) + whole.radiosity_error
    assert np.all(abs(one_by_one.radiosity.sum(1) - whole.radiosity) <= error + 1e-16)
    nothing = rg.evaluate(x, UP, [])
    assert not nothing.radiosity.any() and not nothing.radiosity_error.any() and set(nothing.method) == {"zero"}


def test_occluders_hide():
    lamp = rg.Emitter(SQUARE, 1.0)
    half = [[0, 0, 0.5], [0.5, 0, 0.5], [0.5, 1, 0.5], [0, 1, 0.5]]
    x = np.random.default_rng(2).random((50, 3)) * [1, 1, 0.1]
    free, hidden = rg.evaluate(x, UP, lamp), rg.evaluate(x, UP, lamp, [half])
    assert np.all(hidden.radiosity <= free.radiosity + free.radiosity_error) and np.any(hidden.radiosity < 0.9 * free.radiosity)
    whole = rg.evaluate(x, UP, lamp, [[[-9, -9, 0.6], [9, -9, 0.6], [9, 9, 0.6], [-9, 9, 0.6]]])
    assert not whole.radiosity.any() and not whole.radiosity_error.any()
    assert np.allclose(rg.evaluate(x.astype(np.float32), UP, lamp, [half]).radiosity, hidden.radiosity, rtol=1e-4, atol=1e-6)


def test_single_precision_is_bounded_by_itself():
    lamp = rg.Emitter(SQUARE, [1, 2, 3, 2])
    x = np.random.default_rng(3).random((5000, 3)).astype(np.float32) * np.float32(0.9)
    single, double = rg.evaluate(x, UP, lamp), rg.evaluate(x.astype(np.float64), UP, lamp)
    assert single.radiosity.dtype == single.gradient.dtype == np.float32 and double.radiosity.dtype == np.float64
    assert np.all(abs(single.radiosity - double.radiosity) <= single.radiosity_error.astype(float) + double.radiosity_error)
    off = np.linalg.norm(single.gradient - double.gradient, axis=1)
    assert np.all(off <= single.gradient_error.astype(float) + double.gradient_error)


def test_emissions_of_every_kind():
    values = [1.0, 2.0, 3.0, 2.0]
    same = [
        rg.Emitter(SQUARE, values),
        rg.Emitter(SQUARE, rg.Affine(1.0, [1, 1, 0])),
        rg.Emitter(SQUARE, rg.Polynomial([0, 0, 0], [(1, (0, 0, 0)), (1, (1, 0, 0)), (1, (0, 1, 0))])),
    ]
    x = np.random.default_rng(4).random((20, 3)) * 0.8
    answers = [rg.evaluate(x, UP, lamp) for lamp in same]
    for a in answers[1:]:
        assert np.all(abs(a.radiosity - answers[0].radiosity) <= a.radiosity_error + answers[0].radiosity_error)
    for lamp in same:
        assert np.allclose(lamp.emission_at([[1, 1, 1], [0.5, 0, 1]]), [3, 1.5])
        copy = pickle.loads(pickle.dumps(lamp))
        assert copy == lamp and type(copy) is rg.Emitter and repr(copy).startswith("Emitter([[0.0, 0.0, 1.0]")
    assert same[1].emission == rg.Affine(1.0, [1, 1, 0]) != rg.Affine(1.0, [1, 2, 0])
    assert same[2].emission.terms[1] == (1.0, (1, 0, 0))


def test_derivatives_are_those_of_differences():
    lamp, x, step = rg.Emitter(SQUARE, 1.5), np.array([0.3, 0.2, 0.1]), 1e-5
    h = rg.hessian(x, [0, 0.2, 1], lamp, reflectance=0.5)
    assert h.matrix.shape == (3, 3) and h.error <= 1e-12 * np.linalg.norm(h.matrix)
    for axis in range(3):
        side = [rg.evaluate(x + s * step * np.eye(3)[axis], [0, 0.2, 1], lamp, reflectance=0.5) for s in (1, -1)]
        assert np.allclose((side[0].radiosity - side[1].radiosity) / (2 * step), rg.evaluate(x, [0, 0.2, 1], lamp, reflectance=0.5).gradient[axis], atol=1e-9)
        assert np.allclose((side[0].gradient - side[1].gradient) / (2 * step), h.matrix[axis], atol=1e-8)
    vector = rg.irradiance_vector([x, x], UP, [lamp, lamp])
    assert vector.shape == (2, 3)
    assert np.allclose(vector @ UP / np.pi, 2 * rg.evaluate(x, UP, lamp).radiosity, rtol=1e-14)


def test_trees_answer_many_emitters():
    cells = [[[0.1 * i + a, 0.1 * j + b, 1] for a, b in ((0, 0), (0, 0.1), (0.1, 0.1), (0.1, 0))] for i in range(10) for j in range(10)]
    tree = pickle.loads(pickle.dumps(rg.EmitterTree([rg.Emitter(cell) for cell in cells])))
    x = np.random.default_rng(5).random((200, 3)) * [1, 1, 0.5]
    total, whole = tree.total(x, UP, atol=1e-6), rg.evaluate(x, UP, rg.Emitter(SQUARE))
    assert len(tree) == 100 and np.all(total.radiosity_error <= 1e-6) and total.counts["alone"] > 0
    assert np.all(abs(total.radiosity - whole.radiosity) <= total.radiosity_error + whole.radiosity_error)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda lamp: rg.Emitter([[0, 0], [1, 0], [0, 1]]), ["vertices has shape (3, 2)", "expected (vertices, 3)"]),
        (lambda lamp: rg.Emitter([[0, 0, 0], [1, 0, 0]]), ["at least 3 vertices", "has 2"]),
        (lambda lamp: rg.Emitter([[0, 0, 0], [1, 0, 0], [np.nan, 1, 0]]), ["vertex 2", "NaN", "finite"]),
        (lambda lamp: rg.Emitter([[0, 0, 0], [1, 0, 0], [1, 1, 0.1], [0, 1, 0]]), ["off the plane"]),
        (lambda lamp: rg.Emitter(SQUARE, [1, 2, 3]), ["3 values for 4 vertices"]),
        (lambda lamp: rg.Emitter(SQUARE, [1, 2, 3, 4]), ["affine"]),
        (lambda lamp: rg.Emitter(SQUARE, np.inf), ["emission", "inf", "finite"]),
        (lambda lamp: rg.evaluate([0, 0], UP, lamp), ["x has shape (2,)"]),
        (lambda lamp: rg.evaluate("here", UP, lamp), ["x: expected numbers"]),
        (lambda lamp: rg.evaluate(np.zeros((3, 3)), np.ones((2, 3)), lamp), ["x (3,)", "normal (2,)", "broadcast"]),
        (lambda lamp: rg.evaluate(np.zeros((3, 3)), [0, 0, 0], lamp), ["point 0", "normal", "not zero"]),
        (lambda lamp: rg.evaluate([[0, 0, 0], [0, np.nan, 0]], UP, lamp), ["point 1", "NaN"]),
        (lambda lamp: rg.evaluate([[[0, 0, 0], [0, np.inf, 0]]], UP, lamp), ["point (0, 1)", "inf"]),
        (lambda lamp: rg.evaluate(np.zeros((9000, 3)), UP, lamp, reflectance=[0.5] * 8999 + [2]), ["point 8999", "reflectance is 2"]),
        (lambda lamp: rg.evaluate([0, 0, 0], UP, lamp, rtol=2), ["tolerance is 2", "between 0 and 1"]),
        (lambda lamp: rg.evaluate([0, 0, 0], UP, lamp, [[[0, 0, 0], [1, 1, 1]]]), ["occluder 0", "at least 3 vertices"]),
        (lambda lamp: rg.digits([[0, 0, 0]], UP, lamp), ["shape (1,)", "one point"]),
        (lambda lamp: rg.digits([0, 0, 0], UP, lamp, digits=0), ["digits is 0"]),
        (lambda lamp: rg.EmitterTree([lamp]).total([0, 0, 0], UP, atol=0), ["tolerance"]),
    ],
)
def test_what_is_wrong_is_named(call, words):
    with pytest.raises(ValueError) as refusal:
        call(rg.Emitter(SQUARE))
    for word in words:
        assert word in str(refusal.value)


def test_what_is_no_emitter_is_a_type_error():
    with pytest.raises(TypeError, match=r"emitters\[1\] is str"):
        rg.evaluate([0, 0, 0], UP, [rg.Emitter(SQUARE), "lamp"])


def test_a_million_points_take_seconds_at_most():
    """They take tens of milliseconds; this is to see that no step is of another order."""
    import time

    lamp = rg.Emitter(SQUARE, 1.0)
    x = np.column_stack([np.random.rand(1_000_000, 2), np.zeros(1_000_000)])
    start = time.perf_counter()
    rg.evaluate(x, UP, lamp)
    assert time.perf_counter() - start < 20
