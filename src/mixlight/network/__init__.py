"""Neural networks that estimate light: sparse layers, backbones, heads, and their weights on disk."""

from mixlight.network.sparsemax import SLSparsemax, slsparsemax, sparsemax
from mixlight.network.weights import WeightsError

__all__ = ["SLSparsemax", "WeightsError", "slsparsemax", "sparsemax"]
