"""The programs of the guide run, in the order in which they stand."""

import re

import pytest

from conftest import ROOT


def blocks_of(page):
    guide = ROOT / "docs/guide" / page
    if not guide.is_file():
        pytest.skip("the guide is not beside the tests")
    return guide, re.findall(r"```python\n(.*?)```", guide.read_text(), re.S)


def test_the_guide_of_the_package_runs(tmp_path, monkeypatch):
    guide, blocks = blocks_of("python.md")
    monkeypatch.chdir(tmp_path)
    assert len(blocks) == 4
    names = {}
    for block in blocks:
        exec(compile(block, str(guide), "exec"), names)
    assert names["a"].radiosity.shape == (1_000_000,) and names["s"].summary["estimate"] <= 0.005
    assert names["again"] == names["s"]


@pytest.mark.parametrize("which", range(4), ids=["heat", "light", "planets", "inverse"])
def test_a_program_of_a_persona_runs(which, tmp_path, monkeypatch):
    guide, blocks = blocks_of("personas.md")
    monkeypatch.chdir(tmp_path)
    assert len(blocks) == 4
    names = {}
    exec(compile(blocks[which], str(guide), "exec"), names)
    assert len([line for line in blocks[which].splitlines() if line.strip()]) <= 12
    if which == 0:
        assert names["balance"].T.round(2).tolist() == [300.0, 468.43, 427.66]
        assert abs(names["balance"].q @ names["w"]) < 1e-9
    elif which == 1:
        means = names["s"].by_surface()
        assert set(means) == {"floor", "ceiling", "front", "back", "left", "right", "desk", "shelf", "lamp"}
        assert means["lamp"][0] > 100 > means["desk"][0] > 0
        # All means together are the mean over all area.
        areas = {of["name"]: of["area"] for of in names["s"].summary["surfaces"]}
        mean = sum(areas[name] * means[name][0] for name in means) / sum(areas.values())
        assert abs(mean - names["s"].summary["channels"][0]["mean"]) < 0.05 * mean
    elif which == 2:
        temperatures = rg_heat(names)
        assert temperatures["north"] == max(temperatures.values()) and all(100 < of < 400 for of in temperatures.values())
    else:
        assert (names["powers"] > 0).any() and abs(names["lit"].gather(names["points"], [0, 0, 1]).irradiance[:, 0] - names["wanted"]).max() < 0.05


def rg_heat(names):
    """Temperatures of the crater."""
    found = names["rg"].heat(names["F"], emittance=0.95, q=names["absorbed"], surroundings=3)
    return dict(zip(names["crater"].names, found.T))
