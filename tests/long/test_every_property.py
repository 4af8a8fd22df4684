"""No writable property of any model ends the process, whatever is written to it, and when."""

import pytest
from fleet_conditions import FLYING, NOT_FLYING
from how_many import bounded
from written_properties import deaths

# one of each kind of engine, a glider, an airship; all 59 with all properties take half an hour
SAMPLE = ["737", "ah1s", "c172p", "DHC6", "f16", "SGS", "Submarine_Scout"]


@pytest.mark.long
@pytest.mark.parametrize("aircraft", bounded(SAMPLE, sorted({*FLYING, *NOT_FLYING} - {"blank"})))
def test_no_property_ends_the_process(aircraft):
    assert deaths(aircraft) == []
