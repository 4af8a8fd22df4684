"""Whether a script seeds, or draws from, the shared random generators of NumPy and Python."""

import random
from typing import Any

import numpy as np

_WORDS = 624  # in the state of a Mersenne twister, the type of both generators
_STATES = 2000  # blocks of 624 words; a state not reached within so many draws was set

State = tuple[list[int], int]  # words, and how many of them are used


class SharedGenerators:
    """Compares the generators' states at each `look` with those at the last.

    ``drawn`` tells whether numbers without a seed were drawn; ``set`` names the modules whose
    generator was seeded, or given a state; ``seed`` is the last seed of NumPy's.
    """

    def __init__(self) -> None:
        random.seed()  # drops a cached normal number, whose use would change no state
        np.random.seed()  # noqa: NPY002
        self.drawn, self.seed, self.set = False, None, set[str]()
        self._states = _states()

    def look(self, own: bool = True) -> None:
        """Update the states; ``own`` if the script itself caused the changes since the last."""
        past, self._states = self._states, _states()
        for name, state in self._states.items() if own else ():
            if not _follows(state, past[name]):
                self.set.add(name)
            elif state != past[name]:
                self.drawn = self.drawn or name not in self.set
        seed: Any = self._states["numpy"][0][0]  # if nothing was drawn since
        if self._states["numpy"] == _state(np.random.RandomState(seed)):
            self.seed = seed


def _states() -> dict[str, State]:
    *words, position = random.getstate()[1]
    return {"numpy": _state(np.random), "random": (words, position)}


def _state(generator: Any) -> State:
    _, words, position, *_ = generator.get_state()
    return words.tolist(), position


def _follows(state: State, origin: State) -> bool:
    """Whether one state is reached from another by drawing numbers."""
    generator: Any = np.random.RandomState()
    generator.set_state(("MT19937", origin[0], _WORDS))
    for count in range(_STATES):
        if _state(generator)[0] == state[0]:
            return count > 0 or state[1] >= origin[1]
        generator.bytes(4 * _WORDS)
    return False
