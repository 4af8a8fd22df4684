"""pathsim-flight's classes, typed: with an untyped base, checkers would accept any keyword."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:

    class ISAtmosphere:
        AtmosphereBand: Any

    class CAStoEAS: ...

    class CAStoMach: ...

    class CAStoTAS: ...

    class EAStoTAS: ...

    class MachtoCAS: ...

    class TAStoCAS: ...

else:
    from pathsim_flight.atmosphere import ISAtmosphere as ISAtmosphere
    from pathsim_flight.utils import CAStoEAS as CAStoEAS
    from pathsim_flight.utils import CAStoMach as CAStoMach
    from pathsim_flight.utils import CAStoTAS as CAStoTAS
    from pathsim_flight.utils import EAStoTAS as EAStoTAS
    from pathsim_flight.utils import MachtoCAS as MachtoCAS
    from pathsim_flight.utils import TAStoCAS as TAStoCAS
