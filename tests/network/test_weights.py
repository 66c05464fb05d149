import json
import pickle
from pathlib import Path

import pytest
import torch
from safetensors.torch import save_file
from torch import nn

from mixlight.network import weights
from mixlight.network.weights import WeightsError

CARD = {"name": "test", "licence": "Apache-2.0", "metrics": {"diffuse_rmse": 0.125}, "note": "é"}


class Small(nn.Module):
    def __init__(self):
        super().__init__()
        self.layer = nn.Linear(3, 2)
        self.norm = nn.BatchNorm1d(2)


def card_file(path: Path, document: object) -> Path:
    text = document if isinstance(document, str) else json.dumps(document)
    save_file({"a": torch.zeros(2)}, str(path), metadata={"mixlight": text})
    return path


class TestSaveAndLoad:
    def test_round_trip(self, tmp_path):
        state = Small().state_dict()
        weights.save(tmp_path / "w.safetensors", state, CARD)
        loaded, card = weights.load(tmp_path / "w.safetensors")
        assert card == CARD
        assert loaded.keys() == state.keys()
        for name, tensor in state.items():
            assert loaded[name].dtype == tensor.dtype
            assert torch.equal(loaded[name], tensor)

    def test_golden_bytes(self, tmp_path):
        # A length, a JSON header with the metadata, the numbers: 1.0 and -2.0 as little-endian float32.
        weights.save(tmp_path / "w.safetensors", {"a": torch.tensor([1.0, -2.0])}, {"name": "x"})
        content = (tmp_path / "w.safetensors").read_bytes()
        length = int.from_bytes(content[:8], "little")
        header = json.loads(content[8 : 8 + length])
        assert header["a"] == {"dtype": "F32", "shape": [2], "data_offsets": [0, 8]}
        assert json.loads(header["__metadata__"]["mixlight"]) == {
            "card": {"name": "x"},
            "format": "mixlight/weights",
            "version": 1,
        }
        assert content[8 + length :] == b"\x00\x00\x80\x3f\x00\x00\x00\xc0"

    def test_equal_weights_give_equal_bytes(self, tmp_path):
        state = {name: torch.arange(4.0) for name in ("b", "a", "c")}
        for name, source in (("1", state), ("2", dict(sorted(state.items())))):
            weights.save(tmp_path / f"{name}.safetensors", source, dict(reversed(CARD.items())))
        assert (tmp_path / "1.safetensors").read_bytes() == (tmp_path / "2.safetensors").read_bytes()

    def test_half_keeps_vectors_and_counters(self, tmp_path):
        state = {
            "kernel": torch.tensor([[1 / 3]]),
            "variance": torch.tensor([1e6]),
            "count": torch.tensor([[7]]),
        }
        weights.save(tmp_path / "w.safetensors", state, {}, half=True)
        loaded, _ = weights.load(tmp_path / "w.safetensors")
        assert loaded["kernel"].dtype == torch.float16
        assert loaded["kernel"].item() == pytest.approx(1 / 3, rel=2**-11)
        assert loaded["variance"].item() == 1e6
        assert loaded["count"].dtype == torch.int64

    def test_shared_and_strided_tensors(self, tmp_path):
        base = torch.arange(6.0).view(2, 3)
        weights.save(tmp_path / "w.safetensors", {"a": base.t(), "b": base, "c": base[:, 1]}, {})
        loaded, _ = weights.load(tmp_path / "w.safetensors")
        assert torch.equal(loaded["a"], base.t())
        assert torch.equal(loaded["c"], base[:, 1])

    @pytest.mark.parametrize(
        ("state", "card", "message"),
        [
            ({"a": torch.tensor([1.0, torch.nan])}, {}, "^a: expected finite"),
            ({"a": torch.tensor([[1e5]])}, {}, "^a: expected finite values in the range of torch.float16"),
            ({"a": torch.zeros(1)}, {"path": Path("x")}, "card that JSON can hold"),
            ({"a": torch.zeros(1)}, {"rmse": float("nan")}, "card that JSON can hold"),
        ],
    )
    def test_a_bad_save_leaves_the_old_file(self, tmp_path, state, card, message):
        path = tmp_path / "w.safetensors"
        weights.save(path, {"a": torch.ones(1)}, {"name": "old"})
        with pytest.raises(ValueError, match=message):
            weights.save(path, state, card, half=True)
        assert weights.load(path)[1] == {"name": "old"}
        assert [entry.name for entry in tmp_path.iterdir()] == ["w.safetensors"]

    def test_a_missing_folder(self, tmp_path):
        with pytest.raises(OSError, match="nowhere"):
            weights.save(tmp_path / "nowhere" / "w.safetensors", {}, {})


class TestBadFiles:
    def refused(self, path: Path, message: str) -> None:
        with pytest.raises(WeightsError, match=message) as caught:
            weights.load(path)
        assert str(path) in str(caught.value)
        assert "\n" not in str(caught.value)

    def test_missing_and_folder(self, tmp_path):
        self.refused(tmp_path / "none.safetensors", "found nothing there")
        self.refused(tmp_path, "received a folder")

    @pytest.mark.parametrize(
        "content", [b"x", b"not weights at all", bytes(100), b"\xff" * 64, b'{"a": 1}' * 8]
    )
    def test_other_content(self, tmp_path, content):
        path = tmp_path / "w.safetensors"
        path.write_bytes(content)
        self.refused(path, "received a corrupt one")

    def test_empty(self, tmp_path):
        (tmp_path / "w.safetensors").touch()
        self.refused(tmp_path / "w.safetensors", "received an empty one")

    @pytest.mark.parametrize("keep", [4, 40, 200, -1])
    def test_truncated(self, tmp_path, keep):
        path = tmp_path / "w.safetensors"
        weights.save(path, Small().state_dict(), CARD)
        path.write_bytes(path.read_bytes()[:keep])
        self.refused(path, "received a corrupt one")

    @pytest.mark.parametrize("bare", [True, False])
    def test_a_pickle_is_never_opened(self, tmp_path, bare):
        marker = tmp_path / "ran"

        class Harmful:
            def __reduce__(self):
                return Path.touch, (marker,)

        path = tmp_path / "w.safetensors"
        if bare:
            path.write_bytes(pickle.dumps(Harmful()))
        else:
            torch.save(Harmful(), path)
        self.refused(path, "pickled checkpoint, which could run code and is therefore never opened")
        assert not marker.exists()
        pickle.loads(pickle.dumps(Harmful()))
        assert marker.exists()  # it would have run

    def test_foreign_safetensors(self, tmp_path):
        path = tmp_path / "w.safetensors"
        save_file({"a": torch.zeros(2)}, str(path))
        self.refused(path, "expected weights with a MixLight card, received none")
        save_file({"a": torch.zeros(2)}, str(path), metadata={"format": "pt"})
        self.refused(path, "expected weights with a MixLight card, received none")

    @pytest.mark.parametrize(
        ("document", "message"),
        [
            ("{", "expected a card in JSON"),
            ([], "received format None version None"),
            ({"format": "other", "version": 1, "card": {}}, "received format 'other' version 1"),
            ({"format": "mixlight/weights", "version": 2, "card": {}}, "'mixlight/weights' version 2"),
            ({"format": "mixlight/weights", "version": 1}, "received NoneType"),
            ({"format": "mixlight/weights", "version": 1, "card": "text"}, "received str"),
        ],
    )
    def test_bad_cards(self, tmp_path, document, message):
        self.refused(card_file(tmp_path / "w.safetensors", document), message)

    def test_nan(self, tmp_path):
        path = tmp_path / "w.safetensors"
        text = json.dumps({"format": weights.FORMAT, "version": weights.VERSION, "card": {}})
        save_file({"b": torch.tensor([torch.inf])}, str(path), metadata={"mixlight": text})
        self.refused(path, "received NaN or Inf in b")


class TestFind:
    def test_names_and_paths(self, tmp_path, monkeypatch):
        shipped = weights.find("efficientnet_lite0_imagenet")
        assert shipped.parent == weights.ASSETS
        assert weights.find(shipped) == weights.find(str(shipped)) == shipped
        monkeypatch.chdir(tmp_path)
        for name in ("mine", "mine.safetensors"):
            (tmp_path / name).touch()
        assert weights.find("./mine") == Path("mine")
        assert weights.find("mine.safetensors") == weights.find(Path("mine.safetensors"))
        assert weights.find(Path("mine")) == Path("mine")

    @pytest.mark.parametrize("name", ["unknown", "..", ".", "", "efficientnet_lite0_imagenet.pth"])
    def test_unknown(self, name, tmp_path, monkeypatch):
        monkeypatch.chdir(tmp_path)
        with pytest.raises(WeightsError):
            weights.find(name)

    def test_the_message_lists_what_ships(self):
        with pytest.raises(WeightsError, match=r"unknown model 'unknown'.*efficientnet_lite0_imagenet"):
            weights.find("unknown")

    def test_every_shipped_file_loads(self):
        for name in weights.names():
            state, card = weights.load(weights.find(name))
            assert state
            assert card["licence"]


class TestLoadInto:
    def test_converts_and_keeps_the_dtype(self):
        module = Small()
        state = {
            name: value.half() if value.ndim > 1 else value for name, value in Small().state_dict().items()
        }
        weights.load_into(module, state)
        assert module.layer.weight.dtype == torch.float32
        assert torch.equal(module.layer.weight, state["layer.weight"].float())

    @pytest.mark.parametrize(
        ("change", "message"),
        [
            (lambda s: s.pop("layer.bias"), r"1 missing \(first: layer.bias\)"),
            (lambda s: s.update(other=torch.zeros(1)), r"1 unknown \(first: other\)"),
            (
                lambda s: s.update({"layer.weight": torch.zeros(3, 2)}),
                r"1 of another shape \(first: layer.weight, expected \[2, 3\], received \[3, 2\]\)",
            ),
        ],
    )
    def test_what_does_not_fit_changes_nothing(self, change, message):
        module = Small()
        before = {name: value.clone() for name, value in module.state_dict().items()}
        state = {name: torch.full_like(value, 5) for name, value in before.items()}
        change(state)
        with pytest.raises(WeightsError, match="^here: expected the weights of Small.*" + message):
            weights.load_into(module, state, "here")
        for name, value in module.state_dict().items():
            assert torch.equal(value, before[name])
