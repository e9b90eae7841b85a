"""Derivatives by everything that shapes a point's light, against differences and against identities."""

import numpy as np
import pytest

import radgrad as rg

UP = [0, 0.2, 1.0]
LAMP = np.array([[0, 0, 1.2], [0.1, 1, 1], [1, 0.1, 1.0]])
SCREEN = np.array([[0.3, 0.2, 0.5], [0.9, 0.3, 0.6], [0.4, 0.8, 0.5]])
X = np.array([[0.5, 0.5, 0.0], [0.2, 0.1, -0.1]])
POLYNOMIAL = rg.Polynomial([0.1, 0.2, 0.9], [(1.0, (0, 0, 0)), (0.5, (1, 0, 1)), (-0.3, (0, 2, 0))])


def difference(radiosity, place, step=1e-5):
    """Central differences by every entry of an array."""
    result = np.empty((*np.shape(place), len(X)))
    for entry in np.ndindex(np.shape(place)):
        sides = []
        for s in (step, -step):
            moved = np.array(place, dtype=float)
            moved[entry] += s
            sides.append(radiosity(moved))
        result[entry] = (sides[0] - sides[1]) / (2 * step)
    return np.moveaxis(result, -1, 0)


@pytest.mark.parametrize("emission", [1.5, [1.0, 2.0, 0.5], rg.Affine(1.0, [0.3, -0.2, 0.5]), POLYNOMIAL])
@pytest.mark.parametrize("screens", [[], [SCREEN]])
def test_they_are_those_of_differences(emission, screens):
    d = rg.derivatives(X, UP, rg.Emitter(LAMP, emission), screens, reflectance=0.7)
    assert d.vertices.shape == (2, 3, 3) and d.normal.shape == (2, 3) and d.reflectance.shape == (2,)

    def radiosity(lamp, hiding, share=0.7):
        return rg.evaluate(X, UP, rg.Emitter(lamp, emission), hiding, reflectance=share).radiosity

    assert np.allclose(d.vertices, difference(lambda lamp: radiosity(lamp, screens), LAMP), atol=1e-8)
    if screens:
        assert d.occluders[0].shape == (2, 3, 3) and abs(d.occluders[0]).max() > 1e-3
        assert np.allclose(d.occluders[0], difference(lambda screen: radiosity(LAMP, [screen]), SCREEN), atol=1e-8)
    for i in range(2):
        assert np.all(d.vertices_error[i] <= 1e-12 * np.linalg.norm(d.vertices[i], axis=-1).max() * 3)
    assert np.allclose(d.reflectance * 0.7, d.radiosity, rtol=1e-14)


def test_rigid_motions_and_scales_are_sums_over_vertices():
    values = np.array([1.0, 2.0, 0.5])
    d = rg.derivatives(X, UP, rg.Emitter(LAMP, values), [SCREEN], reflectance=0.7)
    places, all_of = np.concatenate([LAMP, SCREEN]), np.concatenate([d.vertices, d.occluders[0]], axis=1)
    assert np.allclose(all_of.sum(axis=1), d.translation, atol=1e-13)
    about = np.array([0.3, -1.0, 0.4])
    (turned, turned_error), (scaled, scaled_error) = d.rotation(about), d.scale(about)
    assert np.allclose(np.cross(places - about, all_of).sum(axis=1), turned, atol=1e-13)
    assert np.allclose(((places - about) * all_of).sum(axis=(1, 2)), scaled, atol=1e-13)
    assert turned.shape == (2, 3) and np.all(turned_error < 1e-11) and np.all(scaled_error < 1e-11)
    assert np.allclose(d.emission @ values, d.radiosity, rtol=1e-13)


def test_one_point_has_no_axis_of_points_and_none_have_none():
    lamp = rg.Emitter(LAMP)
    d = rg.derivatives(X[0], UP, lamp, [SCREEN])
    assert d.vertices.shape == (3, 3) and d.occluders[0].shape == (3, 3) and d.emission.shape == (1,) and np.shape(d.radiosity) == ()
    assert str(d.method) in rg.METHODS and d.rotation([0, 0, 0])[0].shape == (3,)
    none = rg.derivatives(np.empty((0, 3)), UP, lamp, [SCREEN])
    assert none.vertices.shape == (0, 3, 3) and none.occluders[0].shape == (0, 3, 3) and none.emission.shape == (0, 1)


@pytest.mark.parametrize(
    "words, error, call",
    [
        ("expected radgrad.Emitter", TypeError, lambda: rg.derivatives(X, UP, [rg.Emitter(LAMP)])),
        ("tolerance is 2", ValueError, lambda: rg.derivatives(X, UP, rg.Emitter(LAMP), rtol=2.0)),
        ("about has shape", ValueError, lambda: rg.derivatives(X, UP, rg.Emitter(LAMP)).scale([1.0, 2.0])),
        (r"occluders\[0\] has shape", ValueError, lambda: rg.derivatives(X, UP, rg.Emitter(LAMP), [[1.0, 2.0]])),
    ],
)
def test_wrong_arguments_are_refused(words, error, call):
    with pytest.raises(error, match=words):
        call()
