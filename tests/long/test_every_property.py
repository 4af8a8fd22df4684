"""No writable property of any model ends the process, whatever is written to it, and when."""

import pytest
from fleet_conditions import FLYING, NOT_FLYING
from written_properties import deaths


@pytest.mark.long
@pytest.mark.parametrize("aircraft", sorted({*FLYING, *NOT_FLYING} - {"blank"}))
def test_no_property_ends_the_process(aircraft):
    assert deaths(aircraft) == []
