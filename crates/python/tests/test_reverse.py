"""Backward differentiation: the product that JAX and PyTorch ask for, and these themselves where they are installed."""

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
#: A square that single precision bends by 1e-9.
TURN = np.array([[2.0, -1, 2], [2, 2, -1], [-1, 2, 2]]) / 3
TILTED = [0.3, 0.2, 3.1] + 0.7 * np.array([[-1, -1, 0], [-1, 1, 0], [1, 1, 0], [1, -1, 0]]) @ TURN.T


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


@pytest.fixture(params=[True, False], ids=["double", "single"])
def jax(request):
    module = pytest.importorskip("jax", reason="jax is not installed: rg.jax was not tested")
    module.config.update("jax_enable_x64", request.param)
    return module


@pytest.fixture
def torch():
    return pytest.importorskip("torch", reason="torch is not installed: rg.torch was not tested")


def exact(emission, screens=(SCREEN,)):
    """Value and derivatives of `sum(RATES * forward)`."""
    arguments = (X, NORMAL, LAMP, emission, RHO)
    return RATES @ forward(arguments, screens, 1e-12), backward(RATES, arguments, screens, 1e-12)


@pytest.mark.parametrize("emission", EMISSIONS)
def test_jax_differentiates(jax, emission):
    def total(*given):
        return RATES @ rg.jax.evaluate(*given[:4], given[5:], given[4])

    value, found = jax.jit(jax.value_and_grad(total, argnums=range(6)))(X, NORMAL, LAMP, emission, RHO, SCREEN)
    wanted, slopes = exact(emission)
    # Single precision rounds what is given, too.
    relative = 1e-14 if jax.config.jax_enable_x64 else 1e-5
    assert np.isclose(value, wanted, rtol=relative)
    for by, slope in zip(found, slopes):
        assert by.shape == slope.shape and by.dtype == jax.numpy.result_type(float)
        assert np.abs(by - slope).max() <= relative * np.abs(slope).max()


def test_jax_maps_over_lamps(jax):
    lamps = np.stack([LAMP, LAMP + 0.1])
    slopes = jax.vmap(jax.grad(lambda lamp: RATES @ rg.jax.evaluate(X, NORMAL, lamp)))(lamps)
    wanted = [backward(RATES, (X, NORMAL, lamp, 1.0, 1.0), [], 1e-12)[2] for lamp in lamps]
    assert slopes.shape == (2, 3, 3) and np.allclose(slopes, wanted, atol=1e-14 if jax.config.jax_enable_x64 else 1e-6)


def test_torch_differentiates(torch):
    def tensor(array, **kind):
        return torch.tensor(array, requires_grad=True, **{"dtype": torch.float64, **kind})

    for emission in EMISSIONS:
        given = [tensor(of) for of in (X, NORMAL, LAMP, emission, RHO, SCREEN)]

        def light(x, normal, vertices, emission, reflectance, screen):
            return rg.torch.evaluate(x, normal, vertices, emission, [screen], reflectance)

        value = light(*given)
        assert np.array_equal(value.detach(), rg.evaluate(X, NORMAL, rg.Emitter(LAMP, emission), [SCREEN], RHO).radiosity)
        value.backward(torch.tensor(RATES))
        assert all(np.array_equal(of.grad, slope) for of, slope in zip(given, exact(emission)[1]))
        assert torch.autograd.gradcheck(light, given)


def test_torch_differentiates_by_what_is_asked(torch):
    lamp = torch.tensor(LAMP, dtype=torch.float32, requires_grad=True)
    x = torch.tensor(X[:2], dtype=torch.float32).expand(4, 2, 3)
    value = rg.torch.evaluate(x, NORMAL, lamp)
    assert value.shape == (4, 2) and value.dtype == torch.float32
    value.sum().backward()
    wanted = backward(4.0, (X[:2], NORMAL, LAMP, 1.0, 1.0), [], 1e-12)[2]
    assert lamp.grad.dtype == torch.float32 and np.abs(lamp.grad.numpy() - wanted).max() <= 1e-5 * np.abs(wanted).max() and x.grad is None
    with torch.no_grad():
        assert not rg.torch.evaluate(X, NORMAL, lamp).requires_grad
    # A number is a number, a double makes the answer one; an empty batch has a derivative of 0.
    assert rg.torch.evaluate(X, NORMAL, LAMP).dtype == torch.float64
    (none,) = torch.autograd.grad(rg.torch.evaluate(np.empty((0, 3)), NORMAL, lamp).sum(), lamp)
    assert none.shape == (3, 3) and not none.any()
    slope = torch.autograd.grad(rg.torch.evaluate(X, NORMAL, lamp).sum(), lamp, create_graph=True)[0]
    with pytest.raises(RuntimeError, match="once_differentiable|does not require grad"):
        slope.sum().backward()


@pytest.mark.parametrize("name", ["jax", "torch"])
def test_single_precision_bends_no_square(name):
    pytest.importorskip(name, reason=f"{name} is not installed")
    with pytest.raises(ValueError, match="off the plane"):
        rg.Emitter(TILTED.astype(np.float32).astype(np.float64))
    screen = 0.3 * TILTED + [0.2, 0.1, 0.5]
    value = getattr(rg, name).evaluate(X, NORMAL, TILTED.astype(np.float32), 1.0, [screen.astype(np.float32)])
    wanted = rg.evaluate(X, NORMAL, rg.Emitter(TILTED), [screen]).radiosity
    assert wanted.min() > 1e-3 and np.allclose(value, wanted, rtol=1e-5)


@pytest.mark.parametrize("name", ["jax", "torch"])
@pytest.mark.parametrize(
    "words, change",
    [
        ("^x has shape", {"x": X[:, :2]}),
        ("^x is a masked array", {"x": np.ma.masked_array(X, mask=X > 0.3)}),
        ("^normal has shape", {"normal": 1.0}),
        ("^vertices has shape", {"vertices": LAMP[0]}),
        ("^vertices: expected numbers", {"vertices": rg.Emitter(LAMP)}),
        ("^emission has shape .*a value a vertex", {"emission": [1.0, 2.0]}),
        (r"^occluders\[0\] has shape", {"occluders": SCREEN}),
        ("cannot be broadcast together", {"reflectance": [0.5, 0.6]}),
    ],
)
def test_wrong_arguments_are_named(name, words, change):
    pytest.importorskip(name, reason=f"{name} is not installed")
    with pytest.raises(ValueError, match=words):
        getattr(rg, name).evaluate(**{"x": X, "normal": NORMAL, "vertices": LAMP, **change})


@pytest.mark.parametrize("name", ["jax", "torch"])
def test_what_is_not_installed_is_named(name, monkeypatch):
    module = getattr(rg, name)
    monkeypatch.setitem(__import__("sys").modules, name, None)
    module._differentiable.cache_clear()
    with pytest.raises(ImportError, match=f"pip install {name}"):
        module.evaluate(X, NORMAL, LAMP)
    module._differentiable.cache_clear()
