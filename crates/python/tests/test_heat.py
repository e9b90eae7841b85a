"""Grey bodies in balance."""

import numpy as np
import pytest

import radgrad as rg

SIGMA = 5.670374419e-8
PRISM = [[0, 1 / 3, 2 / 3], [1 / 4, 0, 3 / 4], [2 / 5, 3 / 5, 0]]


def test_two_plates_exchange_what_the_formula_says():
    found = rg.heat([[0, 1], [1, 0]], [0.8, 0.5], T=[400, 300])
    expected = SIGMA * (400.0**4 - 300.0**4) / (1 / 0.8 + 1 / 0.5 - 1)
    assert np.allclose(found.q, [expected, -expected], rtol=1e-13)


def test_the_prism_has_its_temperatures():
    found = rg.heat(PRISM, [0.8, 0.4, 0.6], T=[300, None, None], q=[None, 500, 250])
    assert found.T.round(2).tolist() == [300.0, 468.43, 427.66]
    assert abs(3 * found.q[0] + 4 * 500 + 5 * 250) < 1e-9
    again = rg.heat(PRISM, [0.8, 0.4, 0.6], T=found.T)
    assert np.allclose(again.q, found.q, rtol=1e-11) and np.allclose(again.radiosity, found.radiosity, rtol=1e-12)


def test_an_adiabatic_wall_reradiates():
    found = rg.heat(PRISM, [0.8, 0.4, 0.6], T=[300, 500, None], q=[None, None, 0])
    assert found.q[2] == 0 and 300 < found.T[2] < 500 and np.isclose(SIGMA * found.T[2] ** 4, found.irradiance[2])


def test_a_mirror_has_no_say():
    found = rg.heat(PRISM, [0.8, 0.4, 0.0], T=[300, 500, None], q=[None, None, 0])
    assert np.isclose(found.radiosity[2], found.irradiance[2])


def test_surroundings_stand_in_for_what_is_open():
    found = rg.heat([[0, 0.3], [0.3, 0]], 0.9, T=[350, 350], surroundings=350)
    assert np.allclose(found.q, 0, atol=1e-10) and np.allclose(found.radiosity, SIGMA * 350.0**4)
    assert rg.heat([[0.0]], 0.5, q=[100], surroundings=0).T[0] == pytest.approx((100 / (0.5 * SIGMA)) ** 0.25)


def test_faces_are_named_by_their_surfaces(room):
    F = room.factors().repaired()
    found = rg.heat(F, 0.8, T={"ceiling": 400, "floor": 300}, q={name: 0 for name in ("front", "back", "left", "right")})
    assert np.ptp(found.T[2:]) < 1e-9 and 300 < found.T[2] < 400 and abs(found.q[:2].sum()) < 1e-9
    with pytest.raises(ValueError, match="'lid'.*ceiling"):
        rg.heat(F, 0.8, T={"lid": 400})


def test_the_jacobian_is_that_of_the_heat():
    T, step = np.array([300.0, 420.0, 510.0]), 1e-3
    J = rg.heat.jacobian(PRISM, [0.8, 0.4, 0.6], T)
    for k in range(3):
        ahead, behind = (rg.heat(PRISM, [0.8, 0.4, 0.6], T=T + s * step * np.eye(3)[k]).q for s in (1, -1))
        assert np.allclose(J[:, k], (ahead - behind) / (2 * step), rtol=1e-6)


def test_it_comes_to_rest_where_the_balance_is():
    integrate = pytest.importorskip("scipy.integrate", reason="scipy is not installed")
    emittance, fed = np.array([0.8, 0.4, 0.6]), np.array([0.0, 500.0, 250.0])

    def rate(_, T):
        return np.r_[0.0, (fed - rg.heat(PRISM, emittance, T=T).q)[1:] / 1e4]

    def jacobian(_, T):
        return np.vstack([np.zeros(3), -rg.heat.jacobian(PRISM, emittance, T)[1:] / 1e4])

    end = integrate.solve_ivp(rate, (0, 5e5), [300.0] * 3, method="BDF", jac=jacobian, rtol=1e-8, atol=1e-6).y[:, -1]
    assert np.allclose(end, [300, 468.43, 427.66], atol=0.01)


@pytest.mark.parametrize(
    "call, words",
    [
        (lambda: rg.heat(PRISM, 0.8, T=[300, 400, None]), "body 2 has neither"),
        (lambda: rg.heat(PRISM, 0.8, T=[300, 400, 500], q=[None, None, 0]), "body 2 has both"),
        (lambda: rg.heat(PRISM, 0.8, q=[0, 0, 0]), "no temperature is known"),
        (lambda: rg.heat(PRISM, 1.2, T=[1, 1, 1]), "body 0: its emittance is 1.2"),
        (lambda: rg.heat(PRISM, [0.5, np.nan, 1], T=[1, 1, 1]), "body 1: its emittance is"),
        (lambda: rg.heat(PRISM, 0.8, T=[300, -1, 300]), "body 1: its temperature is -1"),
        (lambda: rg.heat(PRISM, 0.8, T=[300, None, None], q=[None, -1e5, 0]), "below absolute zero"),
        (lambda: rg.heat(PRISM, [0.8, 0, 0.5], T=[300, None, None], q=[None, 5, 0]), "perfect mirror"),
        (lambda: rg.heat([[0, 0.5], [0.5, 0]], 0.8, T=[300, 300]), "surroundings="),
        (lambda: rg.heat([[0, 1.5], [1.5, 0]], 0.8, T=[300, 300]), "above 1"),
        (lambda: rg.heat([[0, np.nan], [1, 0]], 0.8, T=[300, 300]), "body 0: one of the factors of F is NaN"),
        (lambda: rg.heat([[0, 1]], 0.8, T=[300, 300]), r"F has shape \(1, 2\)"),
        (lambda: rg.heat(PRISM, [0.8, 0.8], T=[1, 1, 1]), r"emittance has shape \(2,\)"),
        (lambda: rg.heat(PRISM, 0.8, T={"a": 1}), "without names"),
        (lambda: rg.heat.jacobian(PRISM, 0.8, [300, None, 300]), "T must be known"),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_what_has_no_balance_is_refused(call, words):
    with pytest.raises(ValueError, match=words):
        call()
