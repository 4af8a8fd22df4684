"""End worker processes when the process that started them ends, for any reason."""

from __future__ import annotations

import os
import sys
import threading
import time
from multiprocessing import connection

# s
_INTERVAL = 0.5


def end_with(parent: int) -> None:
    """End this process within seconds of the end of ``parent``, the process that started it.

    A process that is killed cannot end its workers, and idle ones would wait for minutes.
    """
    threading.Thread(target=_watch, args=(parent,), name="end-with-parent", daemon=True).start()


def _watch(parent: int) -> None:
    _wait_for_end(parent)
    # sys.exit would end this thread only
    os._exit(1)


if sys.platform == "win32":

    def _wait_for_end(parent: int) -> None:
        import _winapi

        try:
            handle = _winapi.OpenProcess(0x00100000, False, parent)  # SYNCHRONIZE
        except OSError:  # it has ended already
            return
        connection.wait([handle])
else:

    def _wait_for_end(parent: int) -> None:
        # an orphaned process gets another parent
        while os.getppid() == parent:
            time.sleep(_INTERVAL)
