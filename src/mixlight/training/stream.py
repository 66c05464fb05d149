"""Batches in the order of the steps, made ahead of time by a process of their own."""

from __future__ import annotations

import multiprocessing
from collections.abc import Iterator

from torch.utils.data import DataLoader, Dataset

from mixlight.data.training_set import Batch, TrainingSet
from mixlight.training.features import FeatureBank, FeatureBatch

__all__ = ["stream"]


class _Steps(Dataset[Batch | FeatureBatch]):
    """Batches by step number, for a loader process."""

    def __init__(self, training_set: TrainingSet | FeatureBank, seed: int, size: int) -> None:
        self.training_set, self.seed, self.size = training_set, seed, size

    def __getitem__(self, step: int) -> Batch | FeatureBatch:
        return self.training_set.batch(self.seed, step, self.size)


def stream(
    training_set: TrainingSet | FeatureBank, seed: int, size: int, steps: range, workers: int
) -> Iterator[Batch | FeatureBatch]:
    """The batches of some steps; each depends on the seed and its step alone.

    Args:
        training_set: what the batches are taken from.
        seed: of the views.
        size: views a batch.
        steps: their numbers, in order.
        workers: processes that make batches ahead; 0: each is made when it is asked for. Features lie in
            memory already, and are always read so.
    """
    dataset = _Steps(training_set, seed, size)
    if not workers or isinstance(training_set, FeatureBank):
        return (dataset[step] for step in steps)
    # Forked workers share the panoramas' memory with this process.
    forks = "fork" in multiprocessing.get_all_start_methods()
    loader = DataLoader(
        dataset,
        batch_size=None,
        sampler=steps,
        num_workers=workers,
        prefetch_factor=4,
        multiprocessing_context="fork" if forks else None,
    )
    return iter(loader)
