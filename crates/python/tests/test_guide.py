"""The programs of the guide run, in the order in which they stand."""

import re

import pytest

from conftest import ROOT


def test_the_guide_of_the_package_runs(tmp_path, monkeypatch):
    guide = ROOT / "docs/guide/python.md"
    if not guide.is_file():
        pytest.skip("the guide is not beside the tests")
    monkeypatch.chdir(tmp_path)
    blocks = re.findall(r"```python\n(.*?)```", guide.read_text(), re.S)
    assert len(blocks) == 3
    names = {}
    for block in blocks:
        exec(compile(block, str(guide), "exec"), names)
    assert names["a"].radiosity.shape == (1_000_000,) and names["s"].summary["estimate"] <= 0.005
