"""`evaluate` for PyTorch: its autograd takes the exact derivatives of `radgrad.derivatives`.

>>> import torch, radgrad as rg
>>> lamp = torch.tensor([[0.0, 0, 1], [0, 1, 1], [1, 1, 1], [1, 0, 1]], dtype=torch.float64, requires_grad=True)
>>> rg.torch.evaluate([0.5, 0.5, 0.0], [0.0, 0, 1], lamp, 2.0).backward()
>>> bool(lamp.grad[:, 2].sum() < 0)
True
"""

from __future__ import annotations

import functools
import importlib
from typing import Any, Sequence

import numpy as np

from ._reverse import arrays, backward, forward, points_shape

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
    """The radiosity of points due to one emitter, in closed form, that PyTorch differentiates backwards, once.

    Parameters are those of `radgrad.jax.evaluate`: tensors, or numbers and arrays. Tensors of double precision on the CPU are read where they lie.

    Returns
    -------
    tensor of the shape of the points, in the highest precision of the tensors, where the first of them is
    """
    torch, function = _differentiable()
    given = arrays((x, normal, vertices, emission, reflectance), occluders, lambda value: isinstance(value, torch.Tensor))
    points_shape(given[:5], given[5:])
    floats = [value for value in given if isinstance(value, torch.Tensor) and value.is_floating_point()] or [torch.empty(0, dtype=torch.float64)]
    kind = floats[0].new_empty(0, dtype=functools.reduce(torch.promote_types, (value.dtype for value in floats)))
    # PyTorch takes arrays where they lie, but for those that cannot be written to.
    tensors = (value if isinstance(value, torch.Tensor) else torch.from_numpy(np.require(value, requirements="W")) for value in given)
    return function(rtol, kind, *tensors)


def _made() -> Any:
    """PyTorch, and the function that it differentiates."""
    try:
        torch: Any = importlib.import_module("torch")
    except ImportError:
        raise ImportError("radgrad.torch needs PyTorch: pip install torch") from None

    def numpy(tensors: Any) -> Any:
        return [tensor.detach().cpu().numpy() for tensor in tensors]

    def value(ctx: Any, rtol: float, kind: Any, *tensors: Any) -> Any:
        ctx.rtol = rtol
        ctx.save_for_backward(*tensors)
        given = numpy(tensors)
        return torch.from_numpy(forward(given[:5], given[5:], rtol)).to(kind)

    def pulled_back(ctx: Any, cotangent: Any) -> Any:
        given = numpy(ctx.saved_tensors)
        found = backward(cotangent.cpu().numpy(), given[:5], given[5:], ctx.rtol)
        wanted = zip(found, ctx.saved_tensors, ctx.needs_input_grad[2:])
        return (None, None, *(torch.from_numpy(by).to(tensor) if needed else None for by, tensor, needed in wanted))

    once = torch.autograd.function.once_differentiable(pulled_back)
    function: Any = type("Radiosity", (torch.autograd.Function,), {"forward": staticmethod(value), "backward": staticmethod(once)})
    return torch, function.apply


_differentiable = functools.lru_cache(maxsize=1)(_made)
