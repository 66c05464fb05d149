"""Anchors: against a literal spiral, SciPy's k-d tree, and the figures of the method."""

import math

import numpy as np
import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial import KDTree

from mixlight.sphere import equirect
from mixlight.sphere.points import anchor_map, nearest, neighbours, vogel


def test_vogel_equals_the_spiral_written_out() -> None:
    expected = []
    for i in range(128):
        angle, y = i * math.pi * (3 - math.sqrt(5)), 1 - (2 * i + 1) / 128
        r = math.sqrt(1 - y * y)
        expected.append([r * math.sin(angle), y, -r * math.cos(angle)])
    np.testing.assert_allclose(vogel(128, dtype=torch.float64).numpy(), expected, atol=1e-14)


def test_vogel_golden() -> None:
    np.testing.assert_allclose(
        vogel(128)[[0, 1, 127]].numpy(),
        [[0.0, 0.992188, -0.124756], [0.145388, 0.976563, 0.158706], [-0.007586, -0.992188, 0.124525]],
        atol=2e-6,
    )


@given(st.integers(1, 300))
def test_vogel_points_are_unit_descend_and_balance(count: int) -> None:
    anchors = vogel(count, dtype=torch.float64)
    np.testing.assert_allclose(anchors.norm(dim=-1).numpy(), 1, atol=1e-14)
    assert (anchors[:, 1].diff() < 0).all()
    assert abs(anchors[:, 1].sum().item()) < 1e-9


def test_nearest_neighbours_of_128_anchors_are_15_7_to_17_3_degrees_away() -> None:
    anchors = vogel(128, dtype=torch.float64)
    first = anchors[neighbours(anchors, 1)[:, 0]]
    angles = torch.rad2deg(torch.arccos((anchors * first).sum(-1)))
    assert angles.min().item() == pytest.approx(15.7, abs=0.05)
    assert angles.max().item() == pytest.approx(17.3, abs=0.05)


@given(st.integers(8, 200), st.integers(1, 7))
def test_neighbours_equal_a_k_d_tree(count: int, k: int) -> None:
    anchors = vogel(count, dtype=torch.float64)
    ours = neighbours(anchors, k)
    distance, _ = KDTree(anchors.numpy()).query(anchors.numpy(), k + 1)
    chord = (anchors[ours] - anchors[:, None]).norm(dim=-1)
    np.testing.assert_allclose(chord.numpy(), distance[:, 1:], atol=1e-9)
    assert (ours != torch.arange(count)[:, None]).all()
    assert ours.dtype == torch.int64


def test_equally_near_neighbours_come_by_index() -> None:
    octahedron = torch.cat((torch.eye(3), -torch.eye(3)))
    assert neighbours(octahedron, 5).tolist() == [
        [1, 2, 4, 5, 3],
        [0, 2, 3, 5, 4],
        [0, 1, 3, 4, 5],
        [1, 2, 4, 5, 0],
        [0, 2, 3, 5, 1],
        [0, 1, 3, 4, 2],
    ]


def test_neighbours_do_not_depend_on_the_dtype() -> None:
    assert torch.equal(neighbours(vogel(128)), neighbours(vogel(128, dtype=torch.float64)))


@pytest.mark.parametrize("batch", [(), (5,), (1, 2), (0,)])
def test_nearest_equals_a_k_d_tree(batch: tuple[int, ...]) -> None:
    anchors = vogel(128, dtype=torch.float64)
    directions = torch.randn(*batch, 3, dtype=torch.float64, generator=torch.Generator().manual_seed(1))
    directions = torch.nn.functional.normalize(directions, dim=-1)
    found = nearest(anchors, 3 * directions)  # any length
    _, expected = KDTree(anchors.numpy()).query(directions.reshape(-1, 3).numpy())
    assert found.shape == batch
    np.testing.assert_array_equal(found.flatten().numpy(), expected)


def test_each_anchor_is_nearest_to_itself() -> None:
    assert torch.equal(nearest(vogel(128), vogel(128)), torch.arange(128))


@pytest.mark.parametrize("count", [1, 2, 7, 128, 500])
@pytest.mark.parametrize("size", [(1, 2), (5, 10), (64, 128), (100, 36), (33, 66)])
def test_anchor_map_is_the_nearest_anchor_of_every_pixel(count: int, size: tuple[int, int]) -> None:
    directions = equirect.pixel_directions(*size, dtype=torch.float64)
    expected = nearest(vogel(count, dtype=torch.float64), directions)
    assert torch.equal(anchor_map(count, *size), expected)


def test_anchor_map_returns_a_fresh_tensor_each_time() -> None:
    first = anchor_map(16, 8)
    first.zero_()
    assert anchor_map(16, 8).max() == 15


def test_anchors_share_the_sphere_evenly() -> None:
    share = torch.zeros(128, dtype=torch.float64)
    weights = equirect.solid_angle(256, dtype=torch.float64).flatten()
    share.index_add_(0, anchor_map(128, 256).flatten(), weights)
    assert share.sum().item() == pytest.approx(4 * math.pi)
    # The first and the last anchor, at the ends of the spiral, are the uneven ones.
    assert (share / (4 * math.pi / 128) - 1).abs().max().item() < 0.2


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: vogel(0), "at least 1 point, received 0"),
        (lambda: neighbours(vogel(4), 4), "1 <= k <= 3 for 4 points, received k = 4"),
        (lambda: neighbours(vogel(4), 0), "received k = 0"),
        (lambda: anchor_map(4, 0), "at least 1 x 1, received height 0, width 0"),
        (lambda: anchor_map(0, 4), "received 0"),
    ],
)
def test_bad_counts_are_refused(call: object, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        call()  # type: ignore[operator]
