"""Factors by rays, and their products."""

import pickle

import numpy as np
import pytest

import radgrad as rg


@pytest.fixture(scope="module")
def blocks(data):
    """Two blocks in a room without a wall."""
    return rg.Scene.read(data / "scenes/two_blocks.obj")


def test_intervals_hold_and_rows_close(blocks):
    F = blocks.factors(method="rays", rays=20_000, confidence=0.999)
    scipy = pytest.importorskip("scipy.sparse")
    truth = blocks.factors()
    values, lower, upper = (matrix.toarray() for matrix in (F.values, F.lower, F.upper))
    assert scipy.issparse(F.values) and F.values.indices.dtype == np.int32 and F.exact.shape == F.values.data.shape
    assert np.all(lower <= values) and np.all(values <= upper) and F.rays >= 20_000 and F.confidence == 0.999
    there = values > 0
    least, most = truth.lower.toarray(), truth.upper.toarray()
    assert np.all((lower - 1e-12 <= most)[there]) and np.all((least <= upper + 1e-12)[there])
    assert not np.all(F.exact) and np.all(least[~there] <= F.absent)
    assert np.allclose(values.sum(axis=1) + F.open, 1, rtol=0, atol=1e-14)
    assert np.allclose(blocks.areas[:, None] * values, (blocks.areas[:, None] * values).T, rtol=1e-13)
    assert F == blocks.factors(method="rays", rays=20_000, confidence=0.999)
    assert F != blocks.factors(method="rays", rays=20_000, confidence=0.999, seed=2)


def test_rows_counted_apart_are_the_same_bytes(blocks):
    # The jobs of a cluster, without one.
    from radgrad import distributed
    from radgrad._radgrad import RayCore
    from radgrad._rays import ray_settings

    settings = ray_settings(None, None, 3000, 5, 1e-3)
    sent = (blocks._core.to_bytes(), blocks.notes)
    rows = [distributed._rows(cut, blocks.digest, sent, settings) for cut in distributed._cuts(len(blocks), 7)]
    alone = blocks.factors(method="rays", rays=3000, seed=5, drop_below=1e-3)
    assert len(rows) == 7 and RayCore.join(blocks._core, settings, rows[::-1]).to_bytes() == alone._core.to_bytes()
    for wrong, match in ((rows[:-1], "none of face"), (rows + rows[:1], "one of face"), ([rows[0][:-1]] + rows[1:], "bytes that are none")):
        with pytest.raises(ValueError, match=match):
            RayCore.join(blocks._core, settings, wrong)
    with pytest.raises(ValueError, match="a range of the"):
        distributed._rows((0, len(blocks) + 1), blocks.digest, sent, settings)


def test_products_have_an_error_and_are_kept(blocks, tmp_path):
    F = blocks.factors(method="rays", rays=5000)
    q = np.cos(np.arange(len(blocks)))
    truth = blocks.factors() @ q
    product, error = F.certified(q)
    assert np.array_equal(product, F @ q) and np.all(abs(product - truth) <= error + 1e-3) and np.all(error <= F.error)
    assert np.allclose(F @ np.stack([q, 2 * q], axis=1), np.stack([product, 2 * product], axis=1), rtol=1e-14)
    F.save(tmp_path / "f.npz")
    for copy in (rg.RayFactors.load(tmp_path / "f.npz"), pickle.loads(pickle.dumps(F))):
        assert copy == F and np.array_equal(copy @ q, product) and copy.error == F.error
    with pytest.raises(ValueError, match="shape"):
        F @ q[1:]
    with pytest.raises(ValueError, match="lacks"):
        rg.Factors.load(tmp_path / "f.npz")


def test_far_blocks_are_kept_and_err_by_no_more_than_they_say(blocks, tmp_path):
    F = blocks.factors(method="rays", rays=5000)
    B = F.blocks(0.05)
    q = 1 + np.cos(np.arange(len(blocks)))
    product, error = B.certified(q)
    assert np.array_equal(product, B @ q) and np.all(abs(product - blocks.factors() @ q) <= error + 1e-3)
    assert np.allclose(B @ np.ones(len(blocks)), F @ np.ones(len(blocks)), atol=1e-6) and 0 < B.bytes
    both = B @ np.stack([q, 2 * q], axis=1)
    assert both.shape == (len(blocks), 2) and np.array_equal(both[:, 0], product)
    assert (B @ np.empty((len(blocks), 0))).shape == (len(blocks), 0)
    B.save(tmp_path / "b.npz")
    for copy in (rg.BlockFactors.load(tmp_path / "b.npz"), pickle.loads(pickle.dumps(B))):
        assert copy == B and np.array_equal(copy @ q, product)
    with pytest.raises(ValueError, match="shape"):
        B @ q[1:]
    with pytest.raises(ValueError, match="tolerance"):
        F.blocks(0.0)
    with pytest.raises(ValueError, match="RayFactors"):
        rg.RayFactors.load(tmp_path / "b.npz")
    pytest.importorskip("scipy.sparse.linalg")
    assert np.array_equal(B.operator @ q, product)


def test_an_operator_is_scipy_s(room):
    linalg = pytest.importorskip("scipy.sparse.linalg")
    op = room.operator(rays=5000)
    assert isinstance(op, linalg.LinearOperator) and op.shape == (6, 6) and op.error == op.factors.error
    q = np.arange(6.0)
    assert np.array_equal(op @ q, op.factors @ q)
    # The transpose is that of the matrix.
    assert np.allclose(op.T @ q, op.factors.values.toarray().T @ q, rtol=1e-13)
    # A radiosity, b = e + rho F b.
    b, failed = linalg.gmres(linalg.aslinearoperator(np.eye(6)) - 0.5 * op, np.eye(6)[1])
    assert failed == 0 and np.allclose(b, np.eye(6)[1] + 0.5 * (op @ b), atol=1e-4)


def test_what_does_not_go_together_is_refused(room):
    for settings, words in [
        ({"method": "looks"}, "method is 'looks'"),
        ({"method": "rays", "relative": 0.1}, "relative is 0.1: it does not go with"),
        ({"confidence": 0.9}, "confidence is 0.9: it does not go with"),
        ({"method": "rays", "confidence": 1.0}, "confidence is 1.0"),
        ({"method": "rays", "tolerance": 0.0}, "tolerance is 0.0"),
        ({"method": "rays", "tolerance": 1e-6}, "larger tolerance"),
        ({"method": "rays", "rays": 0}, "rays is 0"),
        ({"method": "rays", "seed": -1}, "seed is -1"),
        ({"method": "rays", "drop_below": 2.0}, "drop_below is 2.0"),
    ]:
        with pytest.raises(ValueError, match=words):
            room.factors(**settings)
