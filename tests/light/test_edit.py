import json
import math
from pathlib import Path

import jsonschema
import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st
from torch import Tensor

from mixlight.image.temperature import white_point_gain
from mixlight.light import document, edit
from mixlight.light.lighting import Group, Lighting
from mixlight.light.lights import merge
from mixlight.light.separate import luminance
from mixlight.sphere import equirect
from mixlight.sphere.frames import rotation

LAMPS = {40: [4.0, 3.0, 2.0], 41: [1.0, 1.0, 1.0], 100: [0.5, 0.5, 1.0], 101: [0.2, 0.2, 0.2]}


def light(lamps: dict[int, list[float]] = LAMPS, dtype: torch.dtype = torch.float32) -> Lighting:
    generator = torch.Generator().manual_seed(5)
    ambient, energy = torch.randn(9, 3, generator=generator).to(dtype), torch.zeros(128, 3, dtype=dtype)
    ambient[0] = 3
    for anchor, rgb in lamps.items():
        energy[anchor] = torch.tensor(rgb, dtype=dtype)
    return Lighting(ambient, energy)


def through_file(lighting: Lighting, folder: Path) -> Lighting:
    document.save(lighting, folder / "light.json")
    return document.load(folder / "light.json")


def same(first: Lighting, second: Lighting) -> None:
    assert torch.equal(first.ambient, second.ambient)
    assert torch.equal(first.energy, second.energy)
    assert first.exposure_gain == second.exposure_gain


class TestTurn:
    @pytest.mark.parametrize("columns", [1, -9, 16, 77])
    def test_the_map_is_the_rolled_map(self, columns: int) -> None:
        """Reference: a turn by whole columns is a roll, which the grid does exactly."""
        lighting = light(dtype=torch.float64)
        turned = edit.turn(lighting, columns * 2 * math.pi / 128).environment(64)
        torch.testing.assert_close(turned, lighting.environment(64).roll(columns, 1), rtol=1e-9, atol=1e-9)

    def test_ahead_goes_to_the_right_and_the_lights_with_it(self) -> None:
        lighting = light()
        turned = edit.turn(lighting, math.pi / 2)
        for before, after in zip(merge(lighting), merge(turned), strict=True):
            assert before.name == after.name
            torch.testing.assert_close(after.irradiance, before.irradiance, rtol=1e-5, atol=1e-6)
            x, y, z = before.direction.tolist()
            assert after.direction.tolist() == pytest.approx([-z, y, x], abs=1e-6)

    @given(angle=st.floats(-10, 10))
    def test_energy_stays_and_turning_back_is_exact(self, angle: float) -> None:
        lighting = light()
        turned = edit.turn(lighting, angle)
        assert torch.equal(turned.energy, lighting.energy)
        torch.testing.assert_close(turned.total_energy(), lighting.total_energy(), rtol=1e-6, atol=0)
        assert -math.pi <= turned.turn <= math.pi
        back = edit.turn(turned, -angle)
        assert back.turn == pytest.approx(0, abs=1e-12)
        torch.testing.assert_close(back.axes, lighting.axes, rtol=0, atol=1e-6)
        torch.testing.assert_close(back.ambient, lighting.ambient, rtol=0, atol=2e-5)

    def test_turned_anchors_are_the_spiral_turned(self) -> None:
        axes = edit.turn(light(dtype=torch.float64), 0.7).axes
        expected = light(dtype=torch.float64).axes @ rotation(0.7, dtype=torch.float64).T
        torch.testing.assert_close(axes, expected, rtol=0, atol=1e-12)

    def test_a_turned_light_still_rotates_freely(self) -> None:
        """Onto its own anchors, which stay turned."""
        turned = edit.turn(light(), 0.3)
        matrix = rotation(0.0, 0.4, 0.2)
        again = turned.rotated(matrix)
        assert again.turn == turned.turn
        for anchor in (40, 100):
            goal = matrix @ turned.axes[anchor]
            best = int((again.axes @ goal).argmax())
            assert bool((again.energy[best] > 0).all())

    @pytest.mark.parametrize("angle", [math.nan, math.inf])
    def test_no_angle(self, angle: float) -> None:
        with pytest.raises(ValueError, match="expected a finite angle"):
            edit.turn(light(), angle)
        with pytest.raises(ValueError, match="expected a finite angle"):
            Lighting(torch.zeros(9, 3), torch.zeros(4, 3), turn=angle)


class TestExposure:
    @given(stops=st.integers(-20, 20))
    def test_whole_stops_are_exact_in_every_number(self, stops: int) -> None:
        lighting = light()
        exposed = edit.expose(lighting, float(stops))
        assert torch.equal(exposed.ambient, lighting.ambient * 2.0**stops)
        assert torch.equal(exposed.energy, lighting.energy * 2.0**stops)
        assert exposed.exposure_gain == 2.0**stops
        same(edit.expose(exposed, -float(stops)), lighting)

    def test_the_map_the_lights_and_the_absolute_light_follow(self) -> None:
        lighting, exposed = light(), edit.expose(light(), 1.5)
        gain = 2**1.5
        torch.testing.assert_close(exposed.environment(32), lighting.environment(32) * gain)
        torch.testing.assert_close(merge(exposed)[0].irradiance, merge(lighting)[0].irradiance * gain)
        torch.testing.assert_close(exposed.absolute().energy, lighting.absolute().energy)

    @pytest.mark.parametrize("ev", [math.nan, math.inf, 41.0, -41.0])
    def test_no_exposure(self, ev: float) -> None:
        with pytest.raises(ValueError, match="expected -40 to 40 EV"):
            edit.expose(light(), ev)


class TestTint:
    @given(kelvin=st.floats(2000, 15000))
    def test_white_light_keeps_its_luminance(self, kelvin: float) -> None:
        white = light({40: [2.0, 2.0, 2.0]}, torch.float64)
        white = Lighting(white.ambient[:, :1].expand(9, 3), white.energy)
        tinted = edit.tint(white, kelvin)
        torch.testing.assert_close(luminance(tinted.energy), luminance(white.energy))
        torch.testing.assert_close(luminance(tinted.ambient), luminance(white.ambient))

    def test_each_channel_times_its_own_number(self) -> None:
        lighting, tinted = light(), edit.tint(light(), 3200)
        gain = torch.tensor(white_point_gain(3200).tolist())
        torch.testing.assert_close(tinted.energy, lighting.energy * gain)
        torch.testing.assert_close(tinted.environment(32), lighting.environment(32) * gain)
        torch.testing.assert_close(edit.tint(lighting, 6504).energy, lighting.energy)

    def test_names_stay_where_the_colour_changes_the_order(self) -> None:
        lamps = {40: [1.0, 1.0, 1.0], 100: [3.0, 0.4, 0.0]}
        assert [found.anchors for found in merge(light(lamps))] == [(40,), (100,)]
        tinted = edit.tint(light(lamps), 2000)
        assert [(found.name, found.anchors) for found in merge(tinted)] == [
            ("light_2", (100,)),
            ("light_1", (40,)),
        ]

    @pytest.mark.parametrize("kelvin", [math.nan, 500.0, 20000.0])
    def test_no_temperature(self, kelvin: float) -> None:
        with pytest.raises(ValueError, match="expected 2000 to 15000 kelvin"):
            edit.tint(light(), kelvin)


class TestLights:
    def test_off_takes_just_that_lights_energy(self) -> None:
        lighting = light()
        first = merge(lighting)[0]
        dark = edit.switch(lighting, "light_1", on=False)
        assert bool((dark.energy[list(first.anchors)] == 0).all())
        torch.testing.assert_close(
            dark.total_energy(), lighting.total_energy() - lighting.energy[list(first.anchors)].sum(0)
        )
        assert [found.name for found in merge(dark)] == [found.name for found in merge(lighting)][1:]
        assert first.name in edit.light_names(dark)
        assert torch.equal(lighting.energy, light().energy)  # nothing in place

    def test_on_undoes_off_through_a_file_and_other_edits(self, tmp_path: Path) -> None:
        lighting = light()
        dark = through_file(edit.switch(lighting, "light_2", on=False), tmp_path)
        same(edit.switch(dark, "light_2", on=True), lighting)
        changed = through_file(edit.turn(edit.tint(edit.expose(dark, 2), 3000), 0.4), tmp_path)
        again = edit.switch(changed, "light_2", on=True)
        straight = edit.turn(edit.tint(edit.expose(lighting, 2), 3000), 0.4)
        torch.testing.assert_close(again.energy, straight.energy)
        torch.testing.assert_close(again.axes, straight.axes, rtol=0, atol=1e-6)
        assert [found.name for found in merge(again)] == [found.name for found in merge(straight)]

    def test_switching_twice_changes_nothing_more(self) -> None:
        dark = edit.switch(light(), "light_1", on=False)
        same(edit.switch(dark, "light_1", on=False), dark)
        assert dark.groups == edit.switch(dark, "light_1", on=False).groups
        same(edit.switch(light(), "light_1", on=True), light())

    def test_strength_multiplies_on_or_off(self) -> None:
        lighting = light()
        anchors = list(merge(lighting)[1].anchors)
        strong = edit.strengthen(lighting, "light_2", 40.0)
        torch.testing.assert_close(strong.energy[anchors], lighting.energy[anchors] * 40)
        assert merge(strong)[0].name == "light_2"  # the brightest now, under its old name
        dark = edit.strengthen(edit.switch(lighting, "light_2", on=False), "light_2", 40.0)
        assert bool((dark.energy[anchors] == 0).all())
        same(edit.switch(dark, "light_2", on=True), strong)

    def test_a_light_dimmed_to_almost_nothing_keeps_its_name(self) -> None:
        """A lobe below 1e-4 of the sources no longer counts by itself; one with a name does."""
        dim = edit.strengthen(light(), "light_2", 1e-7)
        assert "light_2" in [found.name for found in merge(dim)]
        torch.testing.assert_close(edit.strengthen(dim, "light_2", 1e7).energy, light().energy)

    def test_lights_found_later_get_free_names(self) -> None:
        one = edit.named(light({40: [1.0, 1.0, 1.0]}))
        energy = one.energy.clone()
        energy[100] = 9.0
        more = Lighting(one.ambient, energy, groups=one.groups)
        assert [(found.name, found.anchors) for found in merge(more)] == [
            ("light_2", (100,)),
            ("light_1", (40,)),
        ]

    def test_unknown_lights_name_the_known_ones(self) -> None:
        dark = edit.switch(light(), "light_1", on=False)
        known = ", ".join(edit.light_names(dark))
        for call in (
            lambda: edit.switch(dark, "lamp", on=True),
            lambda: edit.strengthen(dark, "lamp", 2.0),
        ):
            with pytest.raises(ValueError, match=f"out of {known}, received 'lamp'"):
                call()
        with pytest.raises(ValueError, match="there is none"):
            edit.switch(light({}), "light_1", on=False)

    @pytest.mark.parametrize("factor", [0.0, -1.0, math.nan, math.inf])
    def test_no_strength(self, factor: float) -> None:
        with pytest.raises(ValueError, match="expected a strength above 0"):
            edit.strengthen(light(), "light_1", factor)

    def test_a_batch_has_no_names(self) -> None:
        batch = Lighting(torch.zeros(2, 9, 3), torch.ones(2, 8, 3))
        for call in (lambda: edit.named(batch), lambda: edit.switch(batch, "light_1", on=False)):
            with pytest.raises(ValueError, match="expected a single lighting"):
                call()
        turned = edit.turn(edit.expose(batch, 1), 0.5)
        assert turned.environment(8).shape == (2, 8, 16, 3)


class TestGroups:
    @pytest.mark.parametrize(
        ("groups", "message"),
        [
            ((Group("", (1,)),), "name of its own"),
            ((Group("a", (1,)), Group("a", (2,))), "name of its own"),
            ((Group("a", ()),), "one at least"),
            ((Group("a", (2, 1)),), "ascending"),
            ((Group("a", (1,)), Group("b", (1, 2))), "each in one group"),
            ((Group("a", (128,)),), "from 0 to 127"),
            ((Group("a", (1, 2), torch.ones(1, 3)),), "for the 2 lobes"),
            ((Group("a", (1,), -torch.ones(1, 3)),), "at least 0"),
            ((Group("a", (40,), torch.ones(1, 3)),), "no energy on the lobes of 'a'"),
        ],
    )
    def test_impossible_groups(self, groups: tuple[Group, ...], message: str, unchecked: None) -> None:
        base = light()
        with pytest.raises(ValueError, match=message):
            Lighting(base.ambient, base.energy, groups=groups)

    def test_free_rotation_and_mirroring_end_names(self) -> None:
        dark = edit.switch(light(), "light_1", on=False)
        assert dark.rotated(rotation(0.3)).groups == ()
        assert dark.mirrored().groups == ()

    def test_groups_follow_device_and_dtype(self) -> None:
        dark = edit.switch(light(), "light_1", on=False).to(torch.float64)
        assert dark.groups[0].off is not None
        assert dark.groups[0].off.dtype == torch.float64


class TestDocument:
    def edited(self) -> Lighting:
        return edit.turn(edit.switch(light(), "light_1", on=False), 0.4)

    def test_version_2_is_valid_and_comes_back(self, tmp_path: Path) -> None:
        lighting = self.edited()
        text = json.loads(document.dumps(document.to_document(lighting)))
        jsonschema.Draft202012Validator(document.schema()).validate(text)
        assert text["version"] == 2
        assert text["sources"]["turn_deg"] == pytest.approx(math.degrees(0.4))
        assert [found["name"] for found in text["lights"]] == edit.light_names(lighting)[1:]
        again = through_file(lighting, tmp_path)
        same(again, lighting)
        assert again.turn == pytest.approx(lighting.turn, abs=1e-15)
        assert torch.equal(again.environment(32), lighting.environment(32))
        for found, group in zip(again.groups, lighting.groups, strict=True):
            assert (found.name, found.anchors) == (group.name, group.anchors)
            assert (found.off is None) == (group.off is None)
            assert found.off is None or torch.equal(found.off, group.off)

    def test_what_needs_no_version_2_stays_version_1(self) -> None:
        for lighting in (light(), edit.expose(light(), 1), edit.turn(edit.turn(light(), 0.4), -0.4)):
            text = document.to_document(lighting)
            assert text["version"] == 1
            assert set(text["sources"]) == {"anchors", "count", "sharpness", "energy"}

    def test_a_file_of_version_1_loads_as_ever(self) -> None:
        text = json.loads(document.dumps(document.to_document(light())))
        again = document.from_document(text)
        assert (again.turn, again.groups) == (0, ())
        same(again, light())

    @pytest.mark.parametrize(
        ("change", "message"),
        [
            (lambda s: s.pop("turn_deg"), "sources: expected the entries"),
            (lambda s: s.update(turn_deg=181), "turn_deg: expected a finite number"),
            (lambda s: s.update(turn_deg="left"), "turn_deg"),
            (lambda s: s["groups"].append(s["groups"][0]), "a name of its own"),
            (lambda s: s["groups"][0].update(name=""), "a name of its own"),
            (lambda s: s["groups"][0].update(anchors=[]), "one at least"),
            (lambda s: s["groups"][1].update(anchors=[128]), "from 0 to 127"),
            (lambda s: s["groups"][1].update(anchors=s["groups"][0]["anchors"]), "in no other group"),
            (lambda s: s["groups"][0].update(off=[[7, 1, 1, 1]]), "on the group's anchors"),
            (lambda s: s["groups"][0].update(colour="red"), "expected the entries name, anchors"),
            (lambda s: s["groups"][1].update(off=[s["energy"][0]]), "every anchor at most once"),
            (lambda s: s["groups"][0]["off"][0].__setitem__(1, -1), "of at least 0"),
        ],
    )
    def test_broken_version_2(self, change: object, message: str) -> None:
        text = document.to_document(self.edited())
        change(text["sources"])  # type: ignore[operator]
        with pytest.raises(ValueError, match=message):
            document.from_document(text)

    def test_version_1_with_entries_of_version_2_is_refused_by_check_and_schema(self) -> None:
        text = {**document.to_document(self.edited()), "version": 1}
        with pytest.raises(ValueError, match="sources: expected the entries"):
            document.check(text)
        with pytest.raises(jsonschema.ValidationError):
            jsonschema.Draft202012Validator(document.schema()).validate(text)


def test_no_light_is_lost_between_map_and_lights() -> None:
    """After any edit: the map without the lights, and the lights' lobes, are the whole map."""
    lighting = edit.strengthen(edit.turn(edit.tint(light(), 4000), 1.0), "light_2", 3.0)
    lights = merge(lighting)
    rest = lighting.without([anchor for found in lights for anchor in found.anchors])
    taken = sum((lighting.energy[list(found.anchors)].sum(0) for found in lights), torch.zeros(3))
    total: Tensor = equirect.integrate(lighting.environment(64))
    torch.testing.assert_close(equirect.integrate(rest.environment(64)) + taken, total, rtol=1e-5, atol=0)
