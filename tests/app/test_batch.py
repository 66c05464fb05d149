import argparse
import json
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mixlight.app import batch
from mixlight.app.batch import Job
from mixlight.app.report import UsageError

OUT = Path("out")


@given(
    st.lists(st.sampled_from(["a.jpg", "b/a.jpg", "A.png", "a-2.jpg", "a-2-2.tif", "..", ".jpg", "b.jpg"]))
)
def test_each_input_gets_a_folder_of_its_own(sources: list[str]) -> None:
    jobs = batch.plan(sources, OUT)
    assert [job.source for job in jobs] == sources
    assert len({str(job.folder).casefold() for job in jobs}) == len(sources)
    assert all(job.folder.parent == OUT and job.folder.name not in ("", ".", "..") for job in jobs)
    assert batch.plan(sources, OUT) == jobs


def test_the_first_of_a_name_keeps_it() -> None:
    names = [
        job.folder.name for job in batch.plan(["x/room.jpg", "y/room.png", "room.v2.jpg", "room.hdr"], OUT)
    ]
    assert names == ["room", "room-2", "room.v2", "room-3"]


def test_a_failure_stops_nobody_else(capsys: pytest.CaptureFixture[str]) -> None:
    def work(job: Job) -> dict[str, object]:
        if job.source == "bad":
            raise ValueError("expected light,\nreceived none")
        if job.source == "gone":
            raise FileNotFoundError(2, "No such file or directory", "gone")
        return {"summary": "done", "lights": 3}

    jobs = batch.plan(["one", "bad", "two", "gone"], OUT)
    assert batch.run_batch(jobs, work, as_json=False) == 1
    out, err = capsys.readouterr()
    assert out.splitlines() == ["one -> out/one/  done", "two -> out/two/  done"]
    assert err.splitlines() == [
        "mixlight: bad: expected light, received none",
        "mixlight: gone: No such file or directory",
        "mixlight: 2 of 4 inputs failed",
    ]
    assert batch.run_batch(jobs[:1], work, as_json=False) == 0


def test_json_has_one_line_for_each_input_good_or_bad(capsys: pytest.CaptureFixture[str]) -> None:
    def work(job: Job) -> dict[str, object]:
        if job.source == "bad":
            raise ValueError("no")
        return {"summary": "done", "lights": 3}

    assert batch.run_batch(batch.plan(["a", "bad", "b"], OUT), work, as_json=True) == 1
    lines = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    assert [line["ok"] for line in lines] == [True, False, True]
    assert lines[0]["out"] == str(OUT / "a")
    assert lines[0]["lights"] == 3
    assert lines[0]["seconds"] >= 0
    assert lines[1] == {"input": "bad", "ok": False, "error": "bad: no"}


def test_a_mistake_of_ours_is_not_taken_for_a_bad_input() -> None:
    def work(job: Job) -> dict[str, object]:
        raise KeyError(job.source)

    with pytest.raises(KeyError):
        batch.run_batch(batch.plan(["a"], OUT), work, as_json=False)


def test_an_output_folder_that_stays_empty_is_taken_away(tmp_path: Path) -> None:
    out = tmp_path / "a" / "b"
    with batch.output_folder(out) as made:
        assert made.is_dir()
    assert not (tmp_path / "a").exists()
    with batch.output_folder(out):
        (out / "x").mkdir()
    assert [p.name for p in out.iterdir()] == ["x"]
    out.joinpath("x").rmdir()
    with batch.output_folder(out):
        pass
    assert out.exists(), "a folder that was there before stays, empty or not"


def test_an_output_folder_that_cannot_be_is_a_usage_error(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    for bad in (tmp_path / "file", tmp_path / "file" / "below", Path("/proc/none/such")):
        with pytest.raises(UsageError, match=f"--out {bad}: expected a folder"), batch.output_folder(bad):
            raise AssertionError
    assert [p.name for p in tmp_path.iterdir()] == ["file"]


@pytest.mark.parametrize("text", ["0", "15", "4097", "12.5", "-128", "x", "", "١٢٨x"])
def test_map_heights_out_of_range_are_refused(text: str) -> None:
    with pytest.raises(argparse.ArgumentTypeError, match="from 16 to 4096"):
        batch.height(text)


@pytest.mark.parametrize("text", ["0", "-1", "nan", "inf", "x"])
def test_caps_out_of_range_are_refused(text: str) -> None:
    with pytest.raises(argparse.ArgumentTypeError, match="above 0"):
        batch.megapixels(text)
