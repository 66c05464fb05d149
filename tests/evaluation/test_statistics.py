"""Means, medians and ratios with intervals over groups."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mixlight.evaluation.statistics import paired_ratio, summarise


def plain_intervals(values: np.ndarray, groups: list[str], resamples: int) -> dict[str, list[float]]:
    """The same bootstrap, written out: draw groups, put their samples side by side."""
    generator = np.random.default_rng(0)
    names = sorted(set(groups))
    members = [np.flatnonzero(np.array(groups) == name) for name in names]
    drawn = []
    for _ in range(resamples):
        chosen = generator.integers(len(names), size=len(names))
        drawn.append(values[np.concatenate([members[k] for k in chosen])])
    return {
        "mean_95": np.quantile([d.mean() for d in drawn], (0.025, 0.975)).tolist(),
        "median_95": np.quantile([np.median(d) for d in drawn], (0.025, 0.975)).tolist(),
    }


@given(st.integers(0, 10_000), st.integers(1, 6), st.integers(1, 5))
def test_summaries_are_those_of_the_plain_bootstrap(seed: int, groups: int, most: int) -> None:
    generator = np.random.default_rng(seed)
    names = [f"g{k}" for k in range(groups) for _ in range(int(generator.integers(1, most + 1)))]
    generator.shuffle(names)
    values = generator.random(len(names)).round(1 if seed % 2 else 9)  # with ties, and without
    found = summarise({"a": values.tolist()}, names, 60)["a"]
    assert found["n"] == len(names)
    assert found["mean"] == pytest.approx(values.mean(), abs=6e-5)
    assert found["median"] == pytest.approx(np.median(values), abs=6e-5)
    for key, interval in plain_intervals(values, names, 60).items():
        if groups == 1:
            assert found[key] is None
            continue
        assert found[key] == pytest.approx(interval, abs=6e-5)


def test_intervals_are_over_groups_not_samples() -> None:
    """Eight equal views of each panorama say no more than one of each."""
    one = np.linspace(0.1, 1.0, 10)
    rooms = [f"room{k}" for k in range(10)]
    single = summarise({"a": one.tolist()}, rooms, 500)["a"]
    views = one.repeat(8).tolist()
    eight = summarise({"a": views}, [room for room in rooms for _ in range(8)], 500)["a"]
    apart = summarise({"a": views}, [str(k) for k in range(80)], 500)["a"]

    def width(cell: dict) -> float:
        return cell["mean_95"][1] - cell["mean_95"][0]

    assert eight["median_95"] == single["median_95"]
    assert eight["mean_95"] == single["mean_95"]
    assert width(eight) > 2 * width(apart)


def test_an_interval_covers_the_mean_about_as_often_as_it_says() -> None:
    generator = np.random.default_rng(7)
    hits = 0
    for _ in range(200):
        values = generator.normal(1.0, 0.5, 40)
        low, high = summarise({"a": values.tolist()}, [str(k) for k in range(40)], 200)["a"]["mean_95"]
        hits += low <= 1.0 <= high
    assert 0.88 <= hits / 200 <= 0.99


def test_what_is_not_defined_is_left_out_and_counted() -> None:
    values = {"a": [1.0, math.nan, 3.0], "b": [math.nan] * 3}
    found = summarise(values, ["x", "y", "z"], 50)
    assert found["a"]["n"] == 2
    assert found["a"]["mean"] == 2.0
    assert found["b"] == {"mean": None, "mean_95": None, "median": None, "median_95": None, "n": 0}


def test_small_numbers_keep_four_digits() -> None:
    assert summarise({"a": [1.23456e-6]}, ["x"], 5)["a"]["mean"] == 1.235e-6


def test_a_ratio_sees_past_what_makes_samples_hard() -> None:
    generator = np.random.default_rng(1)
    hard = np.exp(generator.normal(0, 2, 60))
    groups = [f"g{k // 4}" for k in range(60)]
    ours, theirs = 0.9 * hard * np.exp(generator.normal(0, 0.05, 60)), hard
    found = paired_ratio({"a": ours.tolist()}, {"a": theirs.tolist(), "b": []}, groups)["a"]
    assert found["ratio"] == pytest.approx(0.9, abs=0.02)
    low, high = found["interval_95"]
    assert 0.87 < low < found["ratio"] < high < 0.93
    back = paired_ratio({"a": theirs.tolist()}, {"a": ours.tolist()}, groups)["a"]
    assert back["ratio"] == pytest.approx(1 / found["ratio"], abs=2e-4)
    assert back["first_better"] == pytest.approx(1 - found["first_better"], abs=1e-3)


def test_each_group_counts_once_in_a_ratio() -> None:
    first, second = [1.0, 1.0, 1.0, 4.0], [1.0, 1.0, 1.0, 1.0]
    assert paired_ratio({"a": first}, {"a": second}, ["x", "x", "x", "y"], 50)["a"]["ratio"] == 2.0


def test_zero_and_undefined_errors_have_no_ratio() -> None:
    found = paired_ratio({"a": [0.0, 1.0, math.nan]}, {"a": [1.0, 2.0, 1.0]}, ["x", "y", "z"], 50)["a"]
    assert (found["n"], found["ratio"]) == (1, 0.5)
    assert paired_ratio({"a": [0.0]}, {"a": [1.0]}, ["x"], 50)["a"]["ratio"] is None


def test_bad_input() -> None:
    with pytest.raises(ValueError, match="one group for each of 2 samples, got 1"):
        summarise({"a": [1.0, 2.0]}, ["x"])
    with pytest.raises(ValueError, match="at least one draw"):
        summarise({"a": [1.0]}, ["x"], 0)
