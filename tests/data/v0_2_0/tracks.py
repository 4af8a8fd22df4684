# written for version 0.2.0
from pathlib import Path

from pathsim import Connection, Simulation

from pathsim_jsbsim_blocks import Aircraft, DoubletSource, FlightRecorder
from pathsim_jsbsim_blocks.tracks import save_tracks

plane, recorder = Aircraft("c172p", altitude=4000, speed=95), FlightRecorder()
doublet = DoubletSource(amplitude=0.1, start=1.0, width=1.0)
sim = Simulation(
    [plane, doublet, recorder],
    [
        Connection(doublet, plane["rudder"]),
        *(Connection(plane[n], recorder[n]) for n in ("lat", "lon", "h", "phi", "theta", "psi")),
    ],
    dt=1 / 120,
    log=False,
)
sim.run(10)
track = recorder.to_track()
save_tracks("flight.kml", [track])
assert "coord" in Path("flight.kml").read_text()
print(track.time[-1], track.h[-1], track.psi[-1])
