"""What blocks say of themselves."""

from pathsim_jsbsim_blocks import Aircraft, DoubletSource, JSBSimFDM, PitchHold, UnitConversion


def test_a_block_names_what_differs_from_its_defaults():
    assert repr(DoubletSource(0.2, width=2.0)) == "DoubletSource(amplitude=0.2, width=2.0)"
    assert repr(UnitConversion()) == "UnitConversion()"
    assert repr(PitchHold("737")) == "PitchHold(gains='737')"


def test_an_aircraft_names_its_model_and_condition():
    assert repr(Aircraft("c172p", 5000, 90)) == "Aircraft('c172p', 5000 ft, 90 KCAS)"
    assert repr(Aircraft("737", 30000, mach=0.7)) == "Aircraft('737', 30000 ft, Mach 0.7)"
    ground = JSBSimFDM(aircraft_model="c172p", trim_altitude=0, trim_mode="ground")
    assert repr(ground) == "JSBSimFDM('c172p', on the ground at 0 ft)"
