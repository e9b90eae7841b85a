"""Backward differentiation: the product that JAX asks for, and JAX itself where it is installed."""

import numpy as np
import pytest

import radgrad as rg
from radgrad._reverse import backward, forward

LAMP = np.array([[0.0, 0, 1.2], [0.1, 1, 1], [1, 0.1, 1.0]])
SCREEN = np.array([[0.3, 0.2, 0.5], [0.9, 0.3, 0.6], [0.4, 0.8, 0.5]])
X = np.array([[0.5, 0.5, 0.0], [0.2, 0.1, -0.1], [0.4, 0.3, 0.1]])
# What broadcasts: a normal for all that is no unit vector, a reflectance each.
NORMAL, RHO = np.array([[0.0, 0.4, 2.0]]), np.array([0.7, 0.5, 0.9])
RATES = np.array([1.0, -0.5, 2.0])
EMISSIONS = [np.array(1.5), np.array([1.0, 2.0, 0.5])]


def differences(arguments, occluders, step=1e-5):
    """Of `sum(RATES * forward)` by every entry of every argument."""
    given = [*arguments, *occluders]
    found = []
    for index, array in enumerate(given):
        result = np.empty(np.shape(array))
        for entry in np.ndindex(np.shape(array)):
            sides = []
            for s in (step, -step):
                moved = [np.array(of) for of in given]
                moved[index][entry] += s
                sides.append(RATES @ forward(tuple(moved[:5]), moved[5:], 1e-12))
            result[entry] = (sides[0] - sides[1]) / (2 * step)
        found.append(result)
    return found


@pytest.mark.parametrize("emission", EMISSIONS)
@pytest.mark.parametrize("screens", [[], [SCREEN]])
def test_the_product_is_that_of_differences(emission, screens):
    arguments = (X, NORMAL, LAMP, emission, RHO)
    found = backward(RATES, arguments, screens, 1e-12)
    for by, difference, of in zip(found, differences(arguments, screens), [*arguments, *screens]):
        assert by.shape == np.shape(of) and np.abs(by).max() > 1e-3
        assert np.allclose(by, difference, atol=1e-7), (by, difference)


def test_one_point_has_no_axis():
    found = backward(1.0, (X[0], NORMAL[0], LAMP, 1.5, 0.7), [], 1e-12)
    assert [of.shape for of in found] == [(3,), (3,), (3, 3), (), ()]


@pytest.mark.parametrize("emission", EMISSIONS)
def test_jax_differentiates(emission):
    jax = pytest.importorskip("jax", reason="jax is not installed: rg.jax was not tested")
    jax.config.update("jax_enable_x64", True)

    def total(*given):
        return RATES @ rg.jax.evaluate(X, *given[:3], given[4:], given[3])

    given = (NORMAL, LAMP, emission, RHO, SCREEN)
    value, found = jax.jit(jax.value_and_grad(total, argnums=(0, 1, 2, 3, 4)))(*given)
    exact = backward(RATES, (X, NORMAL, LAMP, emission, RHO), [SCREEN], 1e-12)[1:]
    assert np.isclose(value, RATES @ forward((X, NORMAL, LAMP, emission, RHO), [SCREEN], 1e-12), rtol=1e-14)
    assert all(np.array_equal(a, b) for a, b in zip(found, exact))


@pytest.mark.parametrize("name", ["jax"])
def test_what_is_not_installed_is_named(name, monkeypatch):
    module = getattr(rg, name)
    monkeypatch.setitem(__import__("sys").modules, name, None)
    module._differentiable.cache_clear()
    with pytest.raises(ImportError, match=f"pip install {name}"):
        module.evaluate(X, NORMAL, LAMP)
    module._differentiable.cache_clear()
