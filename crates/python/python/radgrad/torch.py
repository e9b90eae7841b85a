"""`evaluate` for PyTorch: `backward` through it takes the exact derivatives of `radgrad.derivatives`.

>>> import torch, radgrad as rg
>>> lamp = torch.tensor([[0.0, 0, 1], [0, 1, 1], [1, 1, 1], [1, 0, 1]], dtype=torch.float64, requires_grad=True)
>>> rg.torch.evaluate([0.5, 0.5, 0.0], [0.0, 0, 1], lamp, 2.0).backward()
>>> bool(lamp.grad[:, 2].sum() < 0)
True
"""

from __future__ import annotations

import importlib
from functools import lru_cache
from typing import Any, Sequence

import numpy as np

from ._reverse import backward, forward

__all__ = ["evaluate"]


def evaluate(
    x: Any,
    normal: Any,
    vertices: Any,
    emission: Any = 1.0,
    occluders: Sequence[Any] = (),
    reflectance: Any = 1.0,
    rtol: float = 1e-12,
) -> Any:
    """The radiosity of points due to one emitter, in closed form, that PyTorch differentiates backwards.

    Parameters
    ----------
    x, normal, reflectance
        As of `radgrad.evaluate`; they broadcast.
    vertices : (V, 3)
        Of the emitter.
    emission : a number, or (V,)
        The radiosity that it emits, or its value at each vertex, affine in between.
    occluders : sequence of (V_k, 3)
        Polygons that may hide it.
    rtol : float
        Relative error that is asked for.

    Tensors on the CPU of doubles are read where they lie; others are converted. What is no tensor is a constant.

    Returns
    -------
    tensor of the shape of the points, of doubles unless a tensor that was given is of another kind
    """
    torch, differentiable = _differentiable()

    def tensor(of: Any) -> Any:
        return of if isinstance(of, torch.Tensor) else torch.as_tensor(np.asarray(of, dtype=np.float64))

    return differentiable.apply(rtol, *map(tensor, (x, normal, vertices, emission, reflectance, *occluders)))


@lru_cache(maxsize=1)
def _differentiable() -> Any:
    """PyTorch, and a function of a tolerance, the five arguments and each occluder that it differentiates."""
    try:
        torch: Any = importlib.import_module("torch")
    except ImportError:
        raise ImportError("radgrad.torch needs PyTorch: pip install torch") from None

    def arrays(tensors: Any) -> Any:
        found = [of.detach().cpu().to(torch.float64).numpy() for of in tensors]
        return tuple(found[:5]), found[5:]

    class Evaluate(torch.autograd.Function):  # type: ignore[misc,unused-ignore]
        @staticmethod
        def forward(ctx: Any, rtol: float, *given: Any) -> Any:
            ctx.save_for_backward(*given)
            ctx.rtol = rtol
            kind = torch.promote_types(given[0].dtype, given[2].dtype)
            return torch.from_numpy(forward(*arrays(given), rtol)).to(given[2].device, kind)

        @staticmethod
        def backward(ctx: Any, cotangent: Any) -> Any:
            given, (rates,) = ctx.saved_tensors, arrays([cotangent])[0]
            found = zip(backward(rates, *arrays(given), ctx.rtol), given, ctx.needs_input_grad[1:])
            return (None, *(torch.from_numpy(of).to(to.device, to.dtype) if needed else None for of, to, needed in found))

    return torch, Evaluate
