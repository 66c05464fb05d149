"""Renders sets of rooms: plans ahead, keeps Blender busy, and loses nothing when something breaks."""

from __future__ import annotations

import errno
import logging
import os
import queue
import shutil
import tempfile
import threading
import time
from collections.abc import Callable, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import ExitStack
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from mixlight import __version__
from mixlight.blender.program import BlenderError, BlenderMissing, BlenderTimeout
from mixlight.blender.session import Session
from mixlight.data.rooms.balance import balanced, render_gains, restored
from mixlight.data.rooms.catalogue import Catalogue
from mixlight.data.rooms.credits import Credits
from mixlight.data.rooms.job import Settings, read_raw, write_job
from mixlight.data.rooms.make_plan import make_plan
from mixlight.data.rooms.plan import Plan
from mixlight.data.rooms.room_set import DOCUMENT, RoomSet
from mixlight.data.rooms.scene import build
from mixlight.data.rooms.skies import OutdoorSky
from mixlight.data.rooms.store import room_document, write_camera, write_document
from mixlight.image.atomic import atomic_folder

__all__ = ["Outcome", "RenderError", "Rooms", "render_rooms", "switched_on", "threads_of"]

SCRIPT = Path(__file__).with_name("cycles") / "room.py"

_LOG = logging.getLogger(__name__)
_IN_A_ROW = 6
"""Failures one after the other, of rooms with nothing in common, after which it is not the rooms' fault."""

_FULL = (errno.ENOSPC, errno.EDQUOT)
_LITTLE = 256 << 20
"""Bytes left on a disk at which what fails is taken to fail for want of them; about a raw picture."""


class RenderError(RuntimeError):
    """Rendering cannot go on: no Blender, a full disk, or nothing but failures. What is done stays."""


@dataclass(frozen=True)
class Rooms:
    """How the rooms of a set are made."""

    settings: Settings = field(default_factory=Settings)
    cameras: int = 3
    """Panoramas a room."""
    catalogue: Catalogue | None = None
    """Furniture beside our own pieces."""
    skies: tuple[OutdoorSky, ...] = ()
    """Outdoor panoramas; analytic skies if there are none."""
    timeout: float = 3600.0
    """Seconds a room may take in Blender before it is given up."""
    lossless: bool = False
    """Store half floats as they are, at three times the size, instead of by OpenEXR's DWAB."""

    def made_with(self) -> dict[str, Any]:
        """What decides, beside its seed, how a room comes out."""
        library = None if self.catalogue is None else self.catalogue.origin
        made: dict[str, Any] = {
            "mixlight": __version__,
            **asdict(self.settings),
            "cameras": self.cameras,
            "library": library,
            "skies": [sky.name for sky in self.skies],
        }
        # Named only where it is so, since the sets of earlier versions do not say it.
        return made | {"lossless": True} if self.lossless else made


@dataclass(frozen=True)
class Outcome:
    """What became of one room."""

    seed: int
    error: str | None = None
    """Why there is none."""
    seconds: dict[str, float] = field(default_factory=dict)
    """Spent on plan, files, Blender's scene (`build`), light (`render`), noise (`denoise`) and packing."""
    core_seconds: dict[str, float] = field(default_factory=dict)
    """What Blender spent, summed over all cores."""
    panoramas: int = 0
    plan: Plan | None = field(default=None, repr=False)
    """The room; none where it failed."""


def render_rooms(
    seeds: Sequence[int],
    out: Path,
    rooms: Rooms,
    *,
    jobs: int = 1,
    threads: int | None = None,
    report: Callable[[Outcome], None] = lambda outcome: None,
    blender: str | os.PathLike[str] | None = None,
    script: Path = SCRIPT,
) -> list[Outcome]:
    """Render the rooms of some seeds into a set; those that are there already are left alone.

    Each room appears whole or not at all, so that the call can be repeated after anything. A room whose plan,
    scene or picture fails is left out and reported. A Blender that is killed is started again and tries the
    room once more.

    Args:
        seeds: the rooms.
        out: the set's folder.
        rooms: how they are made.
        jobs: Blenders at a time.
        threads: of each Blender; all cores shared out if not given.
        report: is told of every room that is done or has failed, in the caller's thread.
        blender: as for `mixlight.blender.program.run`.
        script: what runs inside Blender.

    Returns:
        One outcome a room that was worked on, in the order in which they ended.

    Raises:
        SetError: the folder holds another set.
        RenderError: it cannot go on; the message says why. What is done stays, and so does the table.
        OSError: the folder cannot be made or written to.
    """
    store = RoomSet(out)
    store.open(rooms.made_with())
    thanks = Credits(store, rooms.catalogue)
    done = store.rooms()
    todo = [seed for seed in dict.fromkeys(seeds) if seed not in done]
    jobs = max(1, min(jobs, len(todo)))
    outcomes: list[Outcome] = []
    in_a_row = 0
    with ExitStack() as stack:
        scratch = stack.enter_context(tempfile.TemporaryDirectory(prefix="mixlight-rooms-"))
        crew = _Crew(store, rooms, todo, Path(scratch))
        stack.callback(store.write_table)
        stack.callback(thanks.write)
        for _ in range(jobs):
            session = stack.enter_context(
                Session(script, [str(threads or threads_of(jobs))], blender=blender)
            )
            worker = _Worker(crew, session)
            worker.start()
            stack.callback(worker.join)
            stack.callback(session.stop)
        stack.callback(crew.stop.set)
        while len(outcomes) < len(todo):
            outcome = crew.next_outcome()
            outcomes.append(outcome)
            in_a_row = 0 if outcome.error is None else in_a_row + 1
            if outcome.plan is not None:
                thanks.add(outcome.plan)
                thanks.write()
                store.write_table()
            report(outcome)
            if in_a_row == _IN_A_ROW:
                raise RenderError(
                    f"{in_a_row} rooms failed one after the other, the last one: {outcome.error}"
                )
    return outcomes


def threads_of(jobs: int) -> int:
    """Threads for each of several Blenders that share the cores."""
    return max(1, (os.cpu_count() or 1) // jobs)


def switched_on(plan: Plan) -> dict[str, bool]:
    """Which light groups are on as the room was planned; all of them are rendered."""
    files = [""] * len(plan.cameras)
    return {light["group"]: bool(light["on"]) for light in room_document(plan, files)["lights"]}


class _Stopped(Exception):
    """A room was given up because all are."""


class _Crew:
    """What the workers share."""

    def __init__(self, store: RoomSet, rooms: Rooms, todo: Sequence[int], scratch: Path) -> None:
        self.store, self.rooms, self.scratch = store, rooms, scratch
        self.stop = threading.Event()
        self._seeds = iter(todo)
        self._lock = threading.Lock()
        self._results: queue.Queue[Outcome | BaseException] = queue.Queue()

    def next_seed(self) -> int | None:
        """The next room to be done; none when all are under way, or all is given up."""
        with self._lock:
            return None if self.stop.is_set() else next(self._seeds, None)

    def put(self, result: Outcome | BaseException) -> None:
        """Tell the caller's thread of a room, or of what ends everything."""
        self._results.put(result)

    def next_outcome(self) -> Outcome:
        """Wait for a room."""
        result = self._results.get()
        if isinstance(result, BaseException):
            raise result
        return result


@dataclass(frozen=True)
class _Ready:
    """A room that Blender can begin with."""

    seed: int
    plan: Plan
    groups: tuple[str, ...]
    folder: Path
    seconds: dict[str, float]


class _Worker(threading.Thread):
    """Keeps one Blender busy: while it renders a room, the next is planned and the last one packed."""

    def __init__(self, crew: _Crew, session: Session) -> None:
        super().__init__(daemon=True)
        self._crew, self._session = crew, session

    def run(self) -> None:
        try:
            with ThreadPoolExecutor(1) as planner, ThreadPoolExecutor(1) as packer:
                packing: Future[None] | None = None
                ahead = self._plan_next(planner)
                while ahead is not None:
                    ready = ahead.result()
                    ahead = self._plan_next(planner)
                    if ready is None:
                        continue
                    answer = self._render(ready)
                    if packing is not None:
                        packing.result()  # never more than one room's raw pictures wait
                    packing = None if answer is None else packer.submit(self._pack, ready, answer)
                if packing is not None:
                    packing.result()
        except _Stopped:
            pass
        except BaseException as error:
            self._crew.put(error)

    def _plan_next(self, planner: ThreadPoolExecutor) -> Future[_Ready | None] | None:
        seed = self._crew.next_seed()
        return None if seed is None else planner.submit(self._prepare, seed)

    def _prepare(self, seed: int) -> _Ready | None:
        rooms, folder = self._crew.rooms, self._crew.scratch / f"room-{seed}"
        start = time.perf_counter()
        try:
            plan = make_plan(seed, library=rooms.catalogue, skies=rooms.skies, cameras=rooms.cameras)
            scene = build(plan, catalogue=rooms.catalogue, skies=rooms.skies)
            planned = time.perf_counter()
            folder.mkdir()
            write_job(balanced(scene, render_gains(plan)), rooms.settings, folder)
        except Exception as error:
            self._fail(seed, error)
            return None
        seconds = {"plan": planned - start, "files": time.perf_counter() - planned}
        return _Ready(seed, plan, scene.groups, folder, seconds)

    def _render(self, ready: _Ready) -> dict[str, Any] | None:
        """Blender's answer; none if the room failed. A Blender that ends gets a second chance."""
        error: Exception | None = None
        for _ in range(2):
            try:
                answer = self._session.ask(ready.folder, self._crew.rooms.timeout)
            except BlenderTimeout as late:
                error = late
                break
            except BlenderMissing as missing:
                raise RenderError(str(missing)) from None
            except BlenderError as ended:
                if self._crew.stop.is_set():
                    raise _Stopped from None
                error = ended
                continue
            if answer["ok"]:
                return answer
            error = ValueError(answer["error"])
            break
        assert error is not None
        self._fail(ready.seed, error)
        shutil.rmtree(ready.folder)
        return None

    def _pack(self, ready: _Ready, answer: dict[str, Any]) -> None:
        """From Blender's raw files to the room's folder in the set."""
        start = time.perf_counter()
        crew = self._crew
        files = [f"camera-{k}.exr" for k in range(len(ready.plan.cameras))]
        seconds = ready.seconds | answer["seconds"]
        on = switched_on(ready.plan)
        codec = "zip" if crew.rooms.lossless else "dwab"
        try:
            with atomic_folder(crew.store.room(ready.seed)) as fresh:
                for index, file in enumerate(files):
                    raw, depth = read_raw(ready.folder / file, ready.groups)
                    groups = restored(raw, render_gains(ready.plan))
                    write_camera(
                        fresh / file, groups, depth, document=DOCUMENT, camera=index, on=on, codec=codec
                    )
                seconds["pack"] = time.perf_counter() - start
                document = room_document(
                    ready.plan,
                    files,
                    render=asdict(crew.rooms.settings),
                    versions={"mixlight": __version__, "blender": answer["blender"]},
                    seconds=_rounded(seconds),
                    core_seconds=_rounded(answer["core_seconds"]),
                )
                write_document(fresh / DOCUMENT, document)
        except Exception as error:
            self._fail(ready.seed, error)
        else:
            crew.put(Outcome(ready.seed, None, seconds, answer["core_seconds"], len(files), ready.plan))
        finally:
            shutil.rmtree(ready.folder)

    def _fail(self, seed: int, error: Exception) -> None:
        """A bad room is reported; a full disk ends everything, as no room would fare better."""
        places = (self._crew.store.folder, self._crew.scratch)
        full = next((folder for folder in places if shutil.disk_usage(folder).free < _LITTLE), None)
        if full is None and isinstance(error, OSError) and error.errno in _FULL:
            full = error.filename  # a quota, perhaps
        if full is not None:
            raise RenderError(
                f"{full}: expected room on the disk, found none; the rooms that are done are kept"
            ) from error
        _LOG.info("room %d failed", seed, exc_info=error)
        known = isinstance(error, ValueError | OSError | BlenderError)
        self._crew.put(Outcome(seed, str(error) if known else f"{type(error).__name__}: {error}"))


def _rounded(seconds: dict[str, float]) -> dict[str, float]:
    return {name: round(value, 3) for name, value in seconds.items()}
