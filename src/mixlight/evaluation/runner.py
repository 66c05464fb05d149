"""Scores methods on the photos of panoramas by a protocol, and can be stopped at any moment."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field

from torch import Tensor

from mixlight import __version__
from mixlight.data.evaluation_set import EvaluationSample, sample_name
from mixlight.data.panoramas import PanoramaRecord, check_split
from mixlight.evaluation.log import Row, ScoreLog, fingerprint
from mixlight.evaluation.methods import Method
from mixlight.evaluation.protocols import Protocol
from mixlight.evaluation.renderers import Renderer
from mixlight.evaluation.scoring import score
from mixlight.light.lighting import Lighting
from mixlight.sphere import equirect

__all__ = ["Failure", "Outcome", "run"]

Progress = Callable[[int], object]
"""Told how many more scores are there."""


@dataclass(frozen=True)
class Failure:
    """Something that could not be scored."""

    source: str
    """The panorama's file, or the method and the sample."""
    error: Exception
    """What went wrong."""


@dataclass
class Outcome:
    """What a run has."""

    rows: list[Row] = field(default_factory=list)
    """Scores, by method in the order given, then by panorama and azimuth."""
    failures: list[Failure] = field(default_factory=list)
    """What is missing from them."""
    left_out: list[str] = field(default_factory=list)
    """Samples that are black, and so have no exposure."""
    scored: int = 0
    """Scores that were worked out now; the others were in the log."""


def run(
    protocol: Protocol,
    records: Sequence[PanoramaRecord],
    methods: Sequence[Method],
    log: ScoreLog,
    renderer: Renderer | None = None,
    progress: Progress = lambda count: None,
) -> Outcome:
    """Scores every method on every photo; what the log holds already is taken from there.

    A panorama or an answer that cannot be read or used is a failure of its samples alone: the others are
    scored, and all that was scored stays in the log.

    Args:
        protocol: what is compared, and how.
        records: the panoramas.
        methods: of different names.
        log: what was scored before; new scores are appended.
        renderer: of the protocol's scene, where it has one.
        progress: is told of scores as they come in.

    Raises:
        ValueError: no panorama, no method, two methods of one name, a split that shares a group, or no
            renderer where the protocol wants one.
    """
    if not records or not methods:
        raise ValueError(f"expected panoramas and methods, got {len(records)} and {len(methods)}")
    names = [method.name for method in methods]
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None:
        raise ValueError(f"expected a name of its own for each method, got {twice!r} twice")
    check_split(records)
    if protocol.scene is not None and renderer is None:
        raise ValueError(f"expected a renderer for the spheres of protocol {protocol.letter}, got none")
    about = None if renderer is None else renderer.about
    common = fingerprint(protocol.to_json(), about, __version__)
    runner = _Runner(protocol, methods, log, renderer, common, progress)
    for record in records:
        runner.panorama(record)
    order = {name: k for k, name in enumerate(names)}
    runner.outcome.rows.sort(key=lambda row: order[row.method])  # stable: panoramas and azimuths stay
    return runner.outcome


class _Runner:
    def __init__(
        self,
        protocol: Protocol,
        methods: Sequence[Method],
        log: ScoreLog,
        renderer: Renderer | None,
        common: str,
        progress: Progress,
    ) -> None:
        self.protocol, self.methods, self.log = protocol, methods, log
        self.renderer, self.common, self.progress = renderer, common, progress
        self.outcome = Outcome()

    def panorama(self, record: PanoramaRecord) -> None:
        """Scores all views of one panorama."""
        try:
            panorama = hashlib.sha256(record.path.read_bytes()).hexdigest()[:16]
            if not self._known(record, panorama):
                for sample in self._views(record):
                    self._sample(record, panorama, sample)
        except (ValueError, OSError, MemoryError) as error:
            self.outcome.failures.append(Failure(str(record.path), error))

    def _known(self, record: PanoramaRecord, panorama: str) -> bool:
        """Whether the log holds all of a panorama, so that its file need not be decoded."""
        rows = []
        for k in range(self.protocol.azimuths):
            name = sample_name(record.scene, 360.0 * k / self.protocol.azimuths)
            for method in self.methods:
                try:
                    print_ = self._print(panorama, record, method, method.version(name))
                except (ValueError, OSError):
                    return False
                row = self.log.find(name, method.name, print_)
                if row is None:
                    return False
                rows.append(row)
        self.outcome.rows += rows
        self.progress(len(rows))
        return True

    def _views(self, record: PanoramaRecord) -> Iterator[EvaluationSample]:
        """The views of a panorama; those that are black are noted."""
        expected = [360.0 * k / self.protocol.azimuths for k in range(self.protocol.azimuths)]
        for sample in self.protocol.samples(record):
            expected.remove(sample.azimuth_deg)
            yield sample
        self.outcome.left_out += [sample_name(record.scene, azimuth) for azimuth in expected]
        self.progress(len(expected) * len(self.methods))

    def _sample(self, record: PanoramaRecord, panorama: str, sample: EvaluationSample) -> None:
        todo: list[tuple[Method, str, Tensor, dict[str, float]]] = []
        for method in self.methods:
            try:
                print_ = self._print(panorama, record, method, method.version(sample.name))
                row = self.log.find(sample.name, method.name, print_)
                if row is not None:
                    self.outcome.rows.append(row)
                    self.progress(1)
                    continue
                todo.append((method, print_, *self._answer(method, sample)))
            except (ValueError, OSError, MemoryError) as error:
                self.outcome.failures.append(Failure(f"{method.name}: {sample.name}", error))
                self.progress(1)
        if not todo:
            return
        found = score(self.protocol, [light for _, _, light, _ in todo], sample.environment, self.renderer)
        for (method, print_, _, more), cells in zip(todo, found, strict=True):
            row = Row(
                sample=sample.name,
                scene=sample.scene,
                group=record.group,
                category=record.category,
                azimuth_deg=sample.azimuth_deg,
                gain=sample.gain,
                method=method.name,
                cells=cells | more,
            )
            self.log.add(row, print_)
            self.outcome.rows.append(row)
            self.outcome.scored += 1
            self.progress(1)

    def _answer(self, method: Method, sample: EvaluationSample) -> tuple[Tensor, dict[str, float]]:
        """The map of a method, and what only its parameters tell."""
        answer = method.answer(sample)
        more = {}
        if self.protocol.lights:
            more["active_anchors"] = math.nan
        if isinstance(answer, Lighting):
            if self.protocol.lights:
                more["active_anchors"] = float(len(answer.active))
            answer = answer.environment(self.protocol.map_height)
        equirect.check(answer)
        return answer, more

    def _print(self, panorama: str, record: PanoramaRecord, method: Method, version: str) -> str:
        return fingerprint(self.common, panorama, record.category, record.group, method.kind, version)
