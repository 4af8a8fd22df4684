"""What contexts put around the runs of their own thread."""

import threading

import pytest
from pathsim import Simulation

from pathsim_jsbsim_blocks import fly
from pathsim_jsbsim_blocks.scripts.runs import replaced_runs


def counting(counts):
    """Counts the runs, by name, that a context sees."""

    def around(usual, sim, name, values):
        counts.append(name)
        return usual(sim, **values)

    return around


def run():
    Simulation([], log=False).run(0.01)


def test_a_second_thread_waits_for_the_end_of_a_context():
    before, counts = Simulation.run, [[], []]
    inside, asking, waited = threading.Event(), threading.Event(), []

    def first():
        with replaced_runs(counting(counts[0])):
            inside.set()
            asking.wait(10)
            run()
            waited.append(len(counts[1]))

    def second():
        inside.wait(10)
        asking.set()
        with replaced_runs(counting(counts[1])):
            run()

    threads = [threading.Thread(target=work) for work in (first, second)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(20)
    assert waited == [0]
    assert counts == [["run"], ["run"]]
    assert Simulation.run is before


def test_runs_of_another_thread_are_not_seen():
    counts = []
    with replaced_runs(counting(counts)):
        thread = threading.Thread(target=run)
        thread.start()
        thread.join(20)
        assert counts == []
        run()
    assert counts == ["run"]


def test_contexts_within_each_other_see_each_run_once():
    before, outer, inner = Simulation.run, [], []
    with replaced_runs(counting(outer)):
        with replaced_runs(counting(inner), "timestep"):
            run()
            fly(Simulation([], log=False), 0.01)
        assert inner == outer == ["run", "fly"]
        run()
    assert (outer, inner) == (["run", "fly", "run"], ["run", "fly"])
    run()
    fly(Simulation([], log=False), 0.01)
    assert len(outer) == 3
    assert Simulation.run is before


def test_an_error_in_a_context_puts_the_methods_back():
    before = Simulation.run
    with pytest.raises(ZeroDivisionError), replaced_runs(counting([]), "timestep"):
        raise ZeroDivisionError
    assert Simulation.run is before
    counts = []
    with replaced_runs(counting(counts)):
        run()
    assert counts == ["run"]
