"""What contexts put around the runs of their own thread."""

import threading

import pytest
from pathsim import Simulation

from pathsim_jsbsim_blocks.scripts.runs import replaced_runs


@pytest.mark.parametrize("first_out", [0, 1])
def test_contexts_of_two_threads_end_in_any_order(first_out):
    """Each sees the runs of its thread alone, until it ends, and nothing stays replaced."""
    before, taken, both = Simulation.run, [[], []], threading.Barrier(2)
    ended = threading.Event()

    def work(k):
        def around(usual, sim, name, given):
            taken[k].append(name)
            return usual(sim, **given)

        with replaced_runs(around):
            both.wait(10)
            if k != first_out:
                ended.wait(10)
            Simulation([], log=False).run(0.01)
        if k == first_out:
            ended.set()

    threads = [threading.Thread(target=work, args=(k,)) for k in (0, 1)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(20)
    assert taken == [["run"], ["run"]]
    assert Simulation.run is before
