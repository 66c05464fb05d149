import entmax
import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st
from torch import Tensor

from mixlight.network.sparsemax import MODES, SLSparsemax, _check_mode, _plain, slsparsemax, sparsemax
from mixlight.sphere.points import neighbours, vogel
from tests.network import slow_sparsemax
from tests.tolerances import TOLERANCE

COUNT = 128
NEAREST = neighbours(vogel(COUNT))
SPARSE_MODES = ("masked", "literal", "sparsemax")


def random_scores(*shape: int, scale: float = 0.05, seed: int = 0) -> Tensor:
    generator = torch.Generator().manual_seed(seed)
    return scale * torch.randn(*shape, generator=generator, dtype=torch.float64)


def patchy_scores(*shape: int, seed: int = 0) -> Tensor:
    """Like a network's: a few bright patches over a low, noisy ground."""
    generator = torch.Generator().manual_seed(seed)
    anchors = vogel(COUNT, dtype=torch.float64)
    centres = torch.randn(*shape, 3, 3, generator=generator, dtype=torch.float64)
    centres = torch.nn.functional.normalize(centres, dim=-1)
    weight = torch.rand(*shape, 3, generator=generator, dtype=torch.float64)
    patches = (weight[..., None] * ((centres @ anchors.T - 1) / 0.02).exp()).sum(-2)
    patches = 1.5 * patches / patches.sum(-1, keepdim=True)
    return patches + 0.02 * torch.randn(*shape, COUNT, generator=generator, dtype=torch.float64)


def slow(scores: Tensor, mode: str, nearest: Tensor = NEAREST) -> Tensor:
    rows = []
    for row in scores.reshape(-1, scores.shape[-1]).tolist():
        if mode == "sparsemax":
            rows.append(slow_sparsemax.plain_reading(row)[0])
            continue
        literal, kept, _ = slow_sparsemax.literal_reading(row, nearest.tolist())
        rows.append(slow_sparsemax.masked(literal, kept) if mode == "masked" else literal)
    return torch.tensor(rows, dtype=scores.dtype).view(scores.shape)


scores_of_rows = st.builds(
    lambda rows, scale, seed: random_scores(rows, COUNT, scale=scale, seed=seed),
    st.integers(1, 4),
    st.sampled_from([0.003, 0.03, 0.3, 3.0]),
    st.integers(0, 2**16),
)


class TestGolden:
    """Worked by hand."""

    ring = torch.tensor([[4, 1], [0, 2], [1, 3], [2, 4], [3, 0]])

    def test_sparsemax(self):
        torch.testing.assert_close(sparsemax(torch.tensor([0.5, 0.25, 2.0])), torch.tensor([0.0, 0.0, 1.0]))
        torch.testing.assert_close(sparsemax(torch.tensor([1.0, 1.0, 0.0])), torch.tensor([0.5, 0.5, 0.0]))

    def test_masked(self):
        # n = (0, -.1, -.2, -.9, -.25); means of neighbours (-.175, -.1, -.5, -.225, -.45); so credibility is
        # -(0, .1, .2 e^.3, .9 e^.675, .25 e^.2) = -(0, .1, .26997, 1.7676, .30535): order 0, 1, 2, 4, 3.
        # sum - k min over the first 4: -.55 + 1 = .45 < 1; with all 5: -1.45 + 4.5 = 3.05. So kappa is 4 and
        # tau_n is -.3875.
        scores = torch.tensor([1.0, 0.9, 0.8, 0.1, 0.75], dtype=torch.float64)
        expected = torch.tensor([0.3875, 0.2875, 0.1875, 0.0, 0.1375], dtype=torch.float64)
        torch.testing.assert_close(slsparsemax(scores, self.ring), expected)
        # n = (0, -.6, -.7, 0, -1), |n - mean| = (.8, .25, .4, .85, 1): order 0, 3, 1, 2.
        # 0, 3 and 1 give -.6 + 1.8 = 1.2, not below 1: kappa 2, tau_n = -.5.
        scores = torch.tensor([1.0, 0.4, 0.3, 1.0, 0.0], dtype=torch.float64)
        expected = torch.tensor([0.5, 0.0, 0.0, 0.5, 0.0], dtype=torch.float64)
        torch.testing.assert_close(slsparsemax(scores, self.ring), expected)

    @pytest.mark.parametrize("dtype", [torch.float32, torch.float64])
    def test_ties_go_to_the_lower_index_and_literal_brings_back_the_rest(self, dtype):
        # A ring of nine, in sixteenths, so that what is equal is equal to the bit. n = 0 for entry 0, -.5 for
        # 1, whose neighbours' mean is -.5 too, -.3125 for 3, 5 and 7 between dark ones at -1. So -credibility
        # is 0, .5 and three times .3125 e^.6875 = .62. sum - k min: .5 for 0 and 1, then .6875, .875 and
        # 1.0625 with 3, 5 and 7: two of three equals fit. tau_n = (-.5 - 2 * .3125 - 1) / 4 = -.53125.
        ring = torch.stack((torch.arange(9) - 1, torch.arange(9) + 1), -1) % 9
        scores = torch.tensor([16, 8, 0, 11, 0, 11, 0, 11, 0], dtype=dtype) / 16
        masked = torch.tensor([0.53125, 0.03125, 0, 0.21875, 0, 0.21875, 0, 0, 0], dtype=dtype)
        torch.testing.assert_close(slsparsemax(scores, ring), masked)
        literal = torch.tensor([0.53125, 0.03125, 0, 0.21875, 0, 0.21875, 0, 0.21875, 0], dtype=dtype)
        torch.testing.assert_close(slsparsemax(scores, ring, "literal"), literal)

    def test_all_equal_gives_all_the_same_share(self):
        scores = torch.full((COUNT,), 0.3)
        torch.testing.assert_close(slsparsemax(scores, NEAREST), torch.full((COUNT,), 1 / COUNT))

    def test_one_anchor(self):
        assert sparsemax(torch.tensor([-3.0])).tolist() == [1.0]


class TestAgainstTheLiteralReading:
    @pytest.mark.parametrize("mode", SPARSE_MODES)
    @pytest.mark.parametrize("shape", [(), (2,), (1, 2)])
    @pytest.mark.parametrize("scale", [0.01, 0.05, 1.0, 20.0])
    def test_random(self, mode, shape, scale):
        scores = random_scores(*shape, COUNT, scale=scale)
        result = slsparsemax(scores, NEAREST, mode)
        torch.testing.assert_close(result, slow(scores, mode), **TOLERANCE[torch.float64])

    @pytest.mark.parametrize("mode", SPARSE_MODES)
    def test_patches(self, mode):
        scores = patchy_scores(12)
        single = slsparsemax(scores.float(), NEAREST, mode)
        torch.testing.assert_close(slsparsemax(scores, NEAREST, mode), slow(scores, mode))
        torch.testing.assert_close(
            single, slow(scores.float().double(), mode).float(), **TOLERANCE[torch.float32]
        )

    @pytest.mark.parametrize("mode", SPARSE_MODES)
    @given(st.lists(st.integers(-32, 32), min_size=12, max_size=12))
    def test_ties_of_every_kind(self, mode, sixteenths):
        nearest = neighbours(vogel(12), 4)  # four, so that means of sixteenths are exact
        scores = torch.tensor(sixteenths, dtype=torch.float64) / 16
        expected = slow(scores, mode, nearest)
        torch.testing.assert_close(slsparsemax(scores, nearest, mode), expected)
        torch.testing.assert_close(slsparsemax(scores.float(), nearest, mode), expected.float())

    @given(scores_of_rows)
    def test_the_condition_holds_on_a_prefix(self, scores):
        for row in scores.tolist():
            _, kept, _ = slow_sparsemax.literal_reading(row, NEAREST.tolist())
            order = slow_sparsemax.literal_reading([0.01 * score for score in row], NEAREST.tolist())[1]
            assert all(slow_sparsemax.holds(row, kept, k) for k in range(1, len(kept) + 1))
            assert kept[0] == order[0] == row.index(max(row))

    @pytest.mark.parametrize("mode", SPARSE_MODES)
    @given(scores=scores_of_rows)
    def test_the_form_for_exporters_is_the_same(self, mode, scores):
        scores.requires_grad_()
        direction = torch.linspace(-1, 1, COUNT, dtype=torch.float64)
        results, gradients = [], []
        for form in (slsparsemax, _plain):
            result = form(scores, NEAREST, mode)
            results.append(result)
            gradients.append(torch.autograd.grad(result, scores, direction.expand_as(result))[0])
        torch.testing.assert_close(results[0], results[1], **TOLERANCE[torch.float64])
        torch.testing.assert_close(gradients[0], gradients[1], **TOLERANCE[torch.float64])


class TestAgainstEntmax:
    @pytest.mark.parametrize("dtype", [torch.float32, torch.float64])
    @pytest.mark.parametrize("scale", [0.01, 1.0, 100.0])
    def test_sparsemax_and_its_gradient(self, dtype, scale):
        scores = random_scores(5, 3, COUNT, scale=scale).to(dtype).requires_grad_()
        direction = torch.linspace(-1, 1, COUNT, dtype=dtype).expand_as(scores)
        results = [sparsemax(scores), entmax.sparsemax(scores, dim=-1)]
        torch.testing.assert_close(*results, **TOLERANCE[dtype])
        torch.testing.assert_close(
            *(torch.autograd.grad(result, scores, direction)[0] for result in results), **TOLERANCE[dtype]
        )

    def test_mode_sparsemax_is_sparsemax(self):
        scores = random_scores(4, COUNT)
        assert torch.equal(slsparsemax(scores, NEAREST, "sparsemax"), sparsemax(scores))


class TestProperties:
    @given(scores_of_rows)
    def test_masked_is_a_distribution_led_by_the_maximum(self, scores):
        result = slsparsemax(scores, NEAREST)
        torch.testing.assert_close(result.sum(-1), torch.ones(len(scores), dtype=torch.float64))
        assert (result >= 0).all()
        assert torch.equal(result.argmax(-1), scores.argmax(-1))

    @given(scores_of_rows, st.floats(-100, 100))
    def test_a_common_offset_changes_nothing(self, scores, offset):
        for mode in SPARSE_MODES:
            torch.testing.assert_close(
                slsparsemax(scores + offset, NEAREST, mode),
                slsparsemax(scores, NEAREST, mode),
                rtol=1e-9,
                atol=1e-9,
            )

    @given(scores_of_rows)
    def test_a_distribution_comes_out_as_it_went_in(self, scores):
        distribution = scores.softmax(-1)
        for mode in SPARSE_MODES:
            torch.testing.assert_close(slsparsemax(distribution, NEAREST, mode), distribution)

    @given(scores_of_rows)
    def test_literal_is_never_sparser_than_sparsemax_and_masked_lies_below_it(self, scores):
        literal = slsparsemax(scores, NEAREST, "literal")
        assert (literal.sum(-1) >= 1 - 1e-12).all()
        assert ((literal > 0) >= (sparsemax(scores) > 0)).all()
        assert (slsparsemax(scores, NEAREST) <= literal + 1e-12).all()

    def test_what_literal_costs(self):
        # Energy out of nothing: a little on patches, most of it in single cases; twice the light on noise.
        patchy = slsparsemax(patchy_scores(256), NEAREST, "literal").sum(-1)
        assert 1.003 < patchy.mean() < 1.01
        assert 1.1 < patchy.max() < 1.3
        noise = slsparsemax(random_scores(256, COUNT, scale=1.0), NEAREST, "literal").sum(-1)
        assert 1.8 < noise.mean() < 2.1
        assert noise.max() > 5

    def test_a_cluster_is_preferred_to_a_lone_entry(self):
        # A ring of 16: a patch that falls from 1 over .84 to .725 on either side, and a lone .84 in the dark.
        ring = torch.stack((torch.arange(16) - 1, torch.arange(16) + 1), -1) % 16
        scores = torch.zeros(16)
        scores[[1, 2, 3, 13, 14, 15, 8]] = 0.84
        scores[[4, 5, 11, 12]] = 0.725
        scores[0] = 1.0
        assert sparsemax(scores).nonzero().flatten().tolist() == [0, 1, 2, 3, 8, 13, 14, 15]
        assert slsparsemax(scores, ring).nonzero().flatten().tolist() == [0, 1, 2, 3, 4, 12, 13, 14, 15]

    @pytest.mark.parametrize("mode", MODES)
    def test_any_leading_shape_and_layout(self, mode):
        scores = random_scores(4, 6, COUNT)
        whole = slsparsemax(scores, NEAREST, mode)
        torch.testing.assert_close(slsparsemax(scores[1, 2], NEAREST, mode), whole[1, 2])
        torch.testing.assert_close(slsparsemax(scores[:0], NEAREST, mode), whole[:0])
        crossed = scores.permute(2, 1, 0).contiguous().permute(2, 1, 0)
        torch.testing.assert_close(slsparsemax(crossed, NEAREST, mode), whole)

    def test_blocks_of_rows_do_not_show(self):
        scores = random_scores(1500, COUNT).float()
        whole = slsparsemax(scores, NEAREST)
        for row in (0, 1023, 1024, 1499):
            torch.testing.assert_close(slsparsemax(scores[row], NEAREST), whole[row])


class TestGradient:
    """Checked where a small step changes no selection; it jumps where one does."""

    @pytest.mark.parametrize("mode", SPARSE_MODES)
    @pytest.mark.parametrize("scores", [random_scores(2, 12, scale=0.3), random_scores(1, 2, 12, scale=0.1)])
    def test_gradcheck(self, mode, scores):
        nearest = neighbours(vogel(12), 4)

        def function(x):
            return slsparsemax(x, nearest, mode)

        assert torch.autograd.gradcheck(function, (scores.clone().requires_grad_(),), eps=1e-7)
        assert torch.autograd.gradgradcheck(function, (scores.clone().requires_grad_(),), eps=1e-7)

    def test_masked_jacobian(self):
        scores = patchy_scores()
        support = (slsparsemax(scores, NEAREST) > 0).double()
        jacobian = torch.autograd.functional.jacobian(lambda x: slsparsemax(x, NEAREST), scores)
        expected = torch.diag(support) - torch.outer(support, support) / support.sum()
        torch.testing.assert_close(jacobian, expected)

    def test_literal_jacobian(self):
        scores = patchy_scores()
        support = (slsparsemax(scores, NEAREST) > 0).double()
        positive = (slsparsemax(scores, NEAREST, "literal") > 0).double()
        jacobian = torch.autograd.functional.jacobian(lambda x: slsparsemax(x, NEAREST, "literal"), scores)
        expected = torch.diag(positive) - torch.outer(positive, support) / support.sum()
        torch.testing.assert_close(jacobian, expected)

    def test_none_passes_everything(self):
        scores = random_scores(3, COUNT).requires_grad_()
        result = slsparsemax(scores, NEAREST, "none")
        assert torch.equal(result, scores)
        result.sum().backward()
        assert torch.equal(scores.grad, torch.ones_like(scores))


class TestEdges:
    @pytest.mark.parametrize("dtype", [torch.float16, torch.bfloat16])
    @pytest.mark.parametrize("mode", SPARSE_MODES)
    def test_half_precision_goes_through_single(self, dtype, mode):
        scores = patchy_scores(3).to(dtype).requires_grad_()
        result = slsparsemax(scores, NEAREST, mode)
        assert result.dtype == dtype
        expected = slsparsemax(scores.detach().float(), NEAREST, mode)
        torch.testing.assert_close(result, expected.to(dtype), rtol=0, atol=0)
        result.sum().backward()
        assert scores.grad.dtype == dtype

    def test_autocast_changes_nothing(self):
        scores = patchy_scores(3).float()
        with torch.autocast("cpu", torch.bfloat16):
            inside = slsparsemax(scores, NEAREST)
        assert torch.equal(inside, slsparsemax(scores, NEAREST))

    @pytest.mark.parametrize("dtype", [torch.float32, torch.float64])
    def test_similarities_below_the_smallest_number_still_rank(self, dtype):
        # |n - mean| is 2999.9 for the dark entry and 1499.8 for the bright one; exp(-1499.8) is 0 in float64.
        triangle = torch.tensor([[1, 2], [0, 2], [0, 1]])
        result = slsparsemax(torch.tensor([7.0, -2993.0, 6.75], dtype=dtype), triangle)
        torch.testing.assert_close(result, torch.tensor([0.625, 0.0, 0.375], dtype=dtype))

    def test_nan_stays_visible(self):
        scores = random_scores(2, COUNT).float()
        scores[1, 5] = torch.nan
        for mode in SPARSE_MODES:
            result = slsparsemax(scores, NEAREST, mode)
            assert result[0].isfinite().all()
            assert result[1].isnan().any()

    def test_scores_are_left_alone(self):
        scores = random_scores(2, COUNT)
        before = scores.clone()
        for mode in SPARSE_MODES:
            slsparsemax(scores, NEAREST, mode)
        assert torch.equal(scores, before)

    def test_module(self):
        layer = SLSparsemax(COUNT, mode="literal")
        scores = random_scores(2, COUNT)
        assert torch.equal(layer(scores), slsparsemax(scores, NEAREST, "literal"))
        assert not layer.state_dict()
        assert repr(layer) == "SLSparsemax(count=128, k=6, mode='literal')"

    def test_exports(self):
        layer = SLSparsemax(COUNT).eval()
        scores = patchy_scores(2).float()
        exported = torch.export.export(layer, (scores,)).module()
        torch.testing.assert_close(exported(scores), layer(scores), **TOLERANCE[torch.float32])

    def test_bad_input(self):
        scores = torch.zeros(2, 4)
        ring = torch.tensor([[3, 1], [0, 2], [1, 3], [2, 0]])
        with pytest.raises(ValueError, match=r"expected a mode out of masked, .*, received 'softmax'"):
            _check_mode("softmax")  # the public functions' types do not let it through in tests
        with pytest.raises(ValueError, match="expected 1 <= k <= 5 for 6 points"):
            SLSparsemax(count=6, k=6)
        with pytest.raises(ValueError, match=r"received torch.float32 \[2, 0\]"):
            sparsemax(torch.zeros(2, 0))
        with pytest.raises(ValueError, match=r"received \[4, 0\]"):
            slsparsemax(scores, ring[:, :0])
