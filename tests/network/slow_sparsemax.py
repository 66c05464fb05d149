"""Sparsemax and the paper's Algorithm 1 word for word: Python floats and loops, one row at a time."""

import math


def literal_reading(scores: list[float], neighbours: list[list[int]]) -> tuple[list[float], list[int], float]:
    """The paper's output, the kappa first indices in their order, and tau."""
    count = len(scores)
    highest = max(scores)
    norm = [score - highest for score in scores]
    credibility = []
    for i in range(count):
        mean = sum(norm[j] for j in neighbours[i]) / len(neighbours[i])
        similarity = math.exp(-abs(norm[i] - mean))
        credibility.append(norm[i] / similarity)
    return _threshold(scores, sorted(range(count), key=lambda i: -credibility[i]))


def plain_reading(scores: list[float]) -> tuple[list[float], list[int], float]:
    """Sparsemax by the same steps: the score is the credibility."""
    return _threshold(scores, sorted(range(len(scores)), key=lambda i: -scores[i]))


def masked(literal: list[float], kept: list[int]) -> list[float]:
    """The paper's output with everything outside the kappa first set to 0."""
    return [value if i in kept else 0.0 for i, value in enumerate(literal)]


def holds(scores: list[float], order: list[int], kappa: int) -> bool:
    """The condition under the maximum in Algorithm 1."""
    first = [scores[i] for i in order[:kappa]]
    return 1 + kappa * min(first) > sum(first)


def _threshold(scores: list[float], order: list[int]) -> tuple[list[float], list[int], float]:
    kappa = max(k for k in range(1, len(scores) + 1) if holds(scores, order, k))
    tau = (sum(scores[i] for i in order[:kappa]) - 1) / kappa
    return [max(score - tau, 0.0) for score in scores], order[:kappa], tau
