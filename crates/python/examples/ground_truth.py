"""Ground truth for someone else's code: random cases of every kind of difficulty, and the errors of a function in each.

    python ground_truth.py
"""

# %% What many programs do: Lambert's formula, without looking at the horizon, in single precision
import numpy as np

import radgrad as rg


def textbook(case):
    """Lambert's sum over the edges, for constant emission and nothing in between."""
    if not isinstance(case.emitter.emission, float):
        raise NotImplementedError("constant emission only")
    seen = (case.emitter.vertices - case.position).astype(np.float32)
    seen = seen / np.linalg.norm(seen, axis=1)[:, None]
    following = np.roll(seen, -1, axis=0)
    across = np.cross(seen, following)
    length = np.linalg.norm(across, axis=1)
    angle = np.arctan2(length, np.sum(seen * following, axis=1))
    edges = np.divide(across, length[:, None], out=np.zeros_like(across), where=length[:, None] > 0) * angle[:, None]
    normal = case.normal / np.linalg.norm(case.normal)
    return float(-case.reflectance * case.emitter.emission / (2 * np.pi) * edges.sum(axis=0) @ normal)


def ours(case):
    a = rg.evaluate(case.position, case.normal, case.emitter, case.occluders, case.reflectance)
    return a.radiosity, a.gradient


# %% Held to exact values in some families of cases
families = ["generic", "far", "contact", "clipped"]
families = [name for name in families if name in rg.audit_families()]
print(f"{'family':<20} {'textbook':>10} {'ours':>10}   worst relative error of the value")
reports = [rg.audit(function, cases=12, families=families, occluders=False) for function in (textbook, ours)]
worst = [{row["family"]: float(row["worst"]) for row in report.figures if row["quantity"] == "value"} for report in reports]
for family in families:
    print(f"{family:<20} {worst[0].get(family, np.nan):10.1e} {worst[1][family]:10.1e}")
assert max(worst[1].values()) < 1e-11 and worst[0]["far"] > 1e-6

# %% What it could not answer is counted, and never left out
for row in reports[0].outcomes:
    print({key: row[key] for key in ("family", "cases", "measured", "unanswered")})

# %% One value to fifty digits, to hold anything against
case = next(rg.cases(1, families=["contact"]))
truth = rg.digits(case.position, case.normal, case.emitter, digits=50, reflectance=case.reflectance)
print(f"{case.name}: {truth.radiosity:.50g}")
