"""Ours and others' code held to truth."""

import numpy as np
import pytest

import radgrad as rg


def test_our_own_answers_are_right():
    report = rg.verify(cases=80, seed=3)
    assert len(report) >= 38 and sum(int(row["non-finite"]) for row in report.outcomes) == 0
    # What outlines in single precision leave open is more.
    figures = [row for row in report.figures if row["family"] != "single"]
    worst = [float(row["worst"]) for row in figures if row["quantity"] in ("value", "gradient")]
    assert len(worst) > 40 and max(worst) < 1e-11
    assert rg.verify(cases=80, seed=3).csv("histogram") == report.csv("histogram")


def test_a_function_is_measured_and_its_faults_are_found():
    def ours(case):
        a = rg.evaluate(case.position, case.normal, case.emitter, case.occluders, case.reflectance)
        return a.radiosity, a.gradient

    def wrong(case):
        radiosity, gradient = ours(case)
        return 1.001 * radiosity, [-gradient[0], gradient[1], gradient[2]]

    def poor(case):
        if case.name.endswith("0"):
            raise RuntimeError("no idea")
        return np.nan if case.name.endswith("1") else 0.0

    families = ["generic", "clipped"]
    figures = {name: rg.audit(f, cases=4, families=families).figures for name, f in (("ours", ours), ("wrong", wrong))}
    assert all(float(row["worst"]) < 1e-12 for row in figures["ours"])
    for row in figures["wrong"]:
        least = 0.9e-3 if row["quantity"] == "value" else 1e-4
        assert float(row["worst"]) > least, row
    outcomes = rg.audit(poor, cases=3, families=["generic"]).outcomes[0]
    assert (outcomes["unanswered"], outcomes["non-finite"], outcomes["measured"]) == ("1", "1", "1")


def test_cases_are_the_same_everywhere_and_wrong_names_are_refused():
    first, again = (next(rg.cases(1, families=["contact"])) for _ in range(2))
    assert first.name == "contact:1:0" and np.array_equal(first.position, again.position) and first.emitter == again.emitter
    with pytest.raises(ValueError, match="contakt"):
        rg.verify(cases=1, families=["contakt"])
    with pytest.raises(ValueError, match="cases is 0"):
        rg.verify(cases=0)
