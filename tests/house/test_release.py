"""A release: one version everywhere, one list of requirements, the same archives each time."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
import tomllib
from hashlib import sha256
from importlib.util import find_spec
from pathlib import Path

import pytest
import yaml

from kinematics.version import __version__

ROOT = Path(__file__).parents[2]
BUILD = """
import sys
from hatchling.build import build_sdist, build_wheel
build_wheel(sys.argv[1])
build_sdist(sys.argv[1])
"""
# What a checkout may hold that is no part of an archive, and changes while tests run.
PASSING = shutil.ignore_patterns(".git", "__pycache__", ".*_cache", ".venv*", "site", "dist")


def test_the_version_is_one():
    changelog = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    assert re.search(r"^## \[([\d.]+)\]", changelog, re.MULTILINE)[1] == __version__
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    assert citation["version"] == __version__
    assert any(source["type"] == "thesis" for source in citation["references"])


def test_the_recipe_has_the_version_and_the_requirements_of_the_package():
    path = ROOT / "recipe" / "recipe.yaml"
    if not path.exists():
        pytest.skip("source archives hold no recipe")
    recipe = yaml.safe_load(path.read_text(encoding="utf-8"))
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert recipe["context"]["version"] == __version__
    wanted = {line.partition(";")[0].replace(" ", "") for line in project["dependencies"]}
    found = {line.replace(" ", "") for line in recipe["requirements"]["run"]}
    assert found == {line.replace("pin>", "pinocchio>") for line in wanted} | {
        "python>=${{python_min}}"
    }
    assert project["requires-python"] == f">={recipe['context']['python_min']}"
    [entry] = project["scripts"].items()
    assert recipe["build"]["python"]["entry_points"] == [" = ".join(entry)]


@pytest.mark.slow
@pytest.mark.skipif(find_spec("hatchling") is None, reason="hatchling, the builder, is missing")
def test_archives_are_the_same_each_time(tmp_path):
    hashes = []
    for name in ("first", "second"):  # copies have dates of their own
        copy = shutil.copytree(ROOT, tmp_path / name, ignore=PASSING, copy_function=shutil.copy)
        done = subprocess.run(
            [sys.executable, "-c", BUILD, str(tmp_path / f"dist_{name}")],
            cwd=copy,
            capture_output=True,
            text=True,
            check=False,
        )
        assert done.returncode == 0, done.stderr
        archives = sorted((tmp_path / f"dist_{name}").iterdir())
        hashes.append([(path.name, sha256(path.read_bytes()).digest()) for path in archives])
    assert hashes[0] == hashes[1] and len(hashes[0]) == 2
