"""The examples of the docstrings run, and the stubs are those of the module."""

import doctest
import importlib
import shutil
import subprocess
import sys

import pytest


@pytest.mark.parametrize("module", ["radgrad", "radgrad._evaluate", "radgrad._scene", "radgrad._audit"])
def test_examples_of_docstrings_run(module):
    found = doctest.testmod(importlib.import_module(module), optionflags=doctest.ELLIPSIS)
    assert found.failed == 0
    assert module == "radgrad._scene" or found.attempted > 0


def test_every_public_name_is_documented():
    import radgrad

    for name in radgrad.__all__:
        assert getattr(radgrad, name).__doc__ if name != "METHODS" and name != "distributed" else True, name


def test_stubs_are_those_of_the_module():
    pytest.importorskip("mypy", reason="mypy is not installed")
    command = shutil.which("stubtest", path=None) or f"{sys.prefix}/bin/stubtest"
    run = subprocess.run([command, "radgrad", "--ignore-missing-stub"], capture_output=True, text=True)
    assert run.returncode == 0, run.stdout + run.stderr
