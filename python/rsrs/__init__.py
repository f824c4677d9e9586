"""Robot swarms from paper to floor: judge, sweep, choose, run again, compare.

Units are in names: ``_m`` metres, ``_s`` seconds, ``_rad`` radians, ``_m_s`` and ``_rad_s`` per second.
What is wrong with an argument raises :class:`RsrsError`, a ``ValueError``.
"""

from ._rsrs import (
    Answers,
    Choice,
    Comparison,
    Diagnosis,
    Explored,
    OrderParameters,
    Picture,
    Profile,
    RsrsError,
    Sweep,
    SweepResult,
    Table,
    Verdict,
    __version__,
    answer,
    compare,
    diagnose,
    explore,
    judge,
    report,
)

__all__ = [
    "Answers",
    "Choice",
    "Comparison",
    "Diagnosis",
    "Explored",
    "OrderParameters",
    "Picture",
    "Profile",
    "RsrsError",
    "Sweep",
    "SweepResult",
    "Table",
    "Verdict",
    "__version__",
    "answer",
    "compare",
    "diagnose",
    "explore",
    "judge",
    "report",
]
