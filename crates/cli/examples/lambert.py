"""The radiosity of a point due to a polygon of constant emission by Lambert's sum, with its gradient, in plain Python.

    radgrad audit --program "python3 lambert.py"

Angles are taken by atan2, so that none is lost next to 0 or pi. What the audit shows is what is left: far away the sum of the value
cancels like the distance over the size, and that of the gradient again. Reads cases as JSON Lines and answers in the format of
`radgrad eval`.
"""

import json
import math
import sys


def sub(a, b):
    return [p - q for p, q in zip(a, b)]


def dot(a, b):
    return sum(p * q for p, q in zip(a, b))


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def above(points, n):
    """Corners of the part above the horizon, each with whether an edge of the polygon starts there."""
    kept = []
    for a, b in zip(points, points[1:] + points[:1]):
        p, q = dot(n, a), dot(n, b)
        if p > 0:
            kept.append((a, True))
        if (p > 0) != (q > 0):
            # From where the boundary leaves the upper half-space it runs along the horizon.
            kept.append(([s + p / (p - q) * (t - s) for s, t in zip(a, b)], p <= 0))
    return kept


def answer(case):
    receiver, emitter = case["receiver"], case["emitter"]
    if "constant" not in emitter["emission"] or case.get("occluders"):
        return {"error": "only constant emission in free sight"}
    x, length = receiver["position"], math.hypot(*receiver["normal"])
    n = [c / length for c in receiver["normal"]]
    vertices = emitter["vertices"]
    points = [sub(v, x) for v in vertices]
    area = [0.0, 0.0, 0.0]
    for a, b in zip(vertices, vertices[1:] + vertices[:1]):
        area = [s + t for s, t in zip(area, cross(sub(a, vertices[0]), sub(b, vertices[0])))]
    if dot(area, points[0]) >= 0:
        return {"radiosity": 0.0, "gradient": [0.0, 0.0, 0.0]}
    seen = above(points, n)
    value, gradient = 0.0, [0.0, 0.0, 0.0]
    for (a, is_edge), (b, _) in zip(seen, seen[1:] + seen[:1]):
        w, e = cross(a, b), sub(b, a)
        m = math.hypot(*w)
        if m == 0:
            continue
        angle = math.atan2(m, dot(a, b))
        value -= angle * dot(n, w) / m
        if is_edge:
            # w times the integral of (n.r) / |r|^4 along the edge.
            ee, ae, na, ne = dot(e, e), dot(a, e), dot(n, a), dot(n, e)
            aa, bb = dot(a, a), dot(b, b)
            first = 0.5 / (m * m) * ((ae + ee) / bb - ae / aa + angle * ee / m)
            second = 0.5 / ee * (1 / aa - 1 / bb)
            integral = (na - ne * ae / ee) * first + ne * second
            gradient = [g - integral * c for g, c in zip(gradient, w)]
    factor = receiver.get("reflectance", 1.0) * emitter["emission"]["constant"] / math.pi
    return {"radiosity": 0.5 * factor * value, "gradient": [factor * g for g in gradient]}


for line in sys.stdin:
    case = json.loads(line)
    try:
        said = answer(case)
    except (ArithmeticError, ValueError) as error:
        said = {"error": str(error)}
    print(json.dumps({"id": case["id"], **said}), flush=True)
