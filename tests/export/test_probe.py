"""One light and harmonics: together all light, whatever the number of lights."""

import torch
from hypothesis import given, settings

from mixlight.export.probe import Probe, describe, make_probe
from mixlight.export.rig import light_harmonics
from tests.export.rigs import Recipe, recipes
from tests.tolerances import TOLERANCE


@settings(max_examples=10)
@given(recipe=recipes())
def test_main_light_and_harmonics_are_the_whole_rig(recipe: Recipe) -> None:
    rig = recipe.rig()
    probe = make_probe(rig)
    on = [probe.main] if probe.main is not None and probe.on else []
    whole = rig.ambient + (light_harmonics(rig.lights) if rig.lights_on else 0)
    torch.testing.assert_close(probe.harmonics + light_harmonics(on), whole, **TOLERANCE[torch.float32])
    assert probe.main is (rig.lights[0] if rig.lights else None)
    assert bool((probe.intensity == 0).all()) == (not on)
    assert float(probe.direction.norm()) == 1 or probe.main is not None


def test_the_words_say_where_the_light_is() -> None:
    nothing = Probe(torch.zeros(9, 3), None, False)
    assert describe(nothing) == "The harmonics hold all light; there is no main light."
    assert nothing.direction.tolist() == [0, 1, 0]
