"""Every number that is published says where it comes from."""

import json
import re
from pathlib import Path
from typing import Any

import pytest

from experiments.provenance import NOTHING_RANDOM, PACKAGES, provenance
from experiments.tables.results import FOLDER
from mixlight.training.card import commit

FILES = sorted(FOLDER.rglob("*.json"))
CLEAN = re.compile(r"[0-9a-f]{7,40}")


def found(path: Path) -> Any:
    return json.loads(path.read_text(encoding="utf-8"))


def named(path: Path) -> str:
    return path.relative_to(FOLDER).with_suffix("").as_posix()


def values(node: Any, key: str) -> list[Any]:
    """All values of a key, however deep."""
    if isinstance(node, list):
        return [value for item in node for value in values(item, key)]
    if isinstance(node, dict):
        here = [node[key]] if key in node else []
        return here + [value for item in node.values() for value in values(item, key)]
    return []


def test_there_are_results() -> None:
    assert len(FILES) > 20


@pytest.mark.parametrize("path", FILES, ids=named)
def test_a_result_names_commit_machine_protocol_n_and_seed(path: Path) -> None:
    result = found(path)
    if path.parent.name == "ablations":  # as `mixlight ablate` writes them
        assert result["machine"]
        assert result["protocol"]["letter"] in ("M", "S")
        assert result["views"] >= result["panoramas"] > 0
        if result["level"] == "network":
            assert all(len(variant["seeds"]) > 1 for variant in result["variants"].values())
        return
    made = (
        [row["provenance"] for row in result["rows"].values()] if "rows" in result else [result["provenance"]]
    )
    for row in made:
        assert "cores" in row["machine"]
        assert all(row[package] for package in ("python", *PACKAGES))
        assert isinstance(row["protocol"], str)
        assert row["protocol"]
        assert row["n"] > 0
        seeds = row["seed"] if isinstance(row["seed"], list) else [row["seed"]]
        assert seeds
        assert all(seed == NOTHING_RANDOM or isinstance(seed, int) for seed in seeds)


@pytest.mark.parametrize("path", FILES, ids=named)
def test_every_commit_of_a_result_is_of_a_clean_tree(path: Path) -> None:
    result = found(path)
    commits = values(result, "commit") + [commit for row in values(result, "commits") for commit in row]
    assert commits
    assert [text for text in commits if not CLEAN.fullmatch(text)] == []
    assert "-dirty" not in path.read_text(encoding="utf-8")


@pytest.mark.parametrize("path", FILES, ids=named)
def test_no_result_holds_a_path_of_the_machine_that_made_it(path: Path) -> None:
    found_in = re.findall(r'"/[\w.-]+/[^"]*"', path.read_text(encoding="utf-8"))
    assert found_in == []


def test_provenance() -> None:
    made = provenance("M", 96, range(2))
    assert made["commit"] == commit()
    assert (made["protocol"], made["n"], made["seed"]) == ("M", 96, [0, 1])
    assert provenance("M", 1, 0)["seed"] == 0
    assert provenance("M", 1, None)["seed"] == NOTHING_RANDOM
    with pytest.raises(ValueError, match="one thing or more, got 0"):
        provenance("M", 0, None)
