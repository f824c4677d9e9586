"""Robot swarms from paper to floor: judge, sweep, choose, run again, compare.

Units are in names: ``_m`` metres, ``_s`` seconds, ``_rad`` radians, ``_m_s`` and ``_rad_s`` per second.
What is wrong with an argument raises :class:`RsrsError`, a ``ValueError``. Environments for learning,
``parallel_env`` and ``vector_env``, need gymnasium and pettingzoo beside this package.
"""

from typing import TYPE_CHECKING, Any

from ._rsrs import (
    Answers,
    Bag,
    Choice,
    Comparison,
    Conditions,
    Diagnosis,
    Explored,
    Fit,
    OrderParameters,
    Picture,
    Profile,
    RsrsError,
    Sweep,
    SweepResult,
    Table,
    Trajectory,
    Validation,
    Verdict,
    Worlds,
    __version__,
    answer,
    compare,
    diagnose,
    episode,
    explore,
    fit,
    judge,
    report,
    validate,
)

if TYPE_CHECKING:
    from .environments import parallel_env as parallel_env
    from .environments import vector_env as vector_env

__all__ = [
    "Answers",
    "Bag",
    "Choice",
    "Comparison",
    "Conditions",
    "Diagnosis",
    "Explored",
    "Fit",
    "OrderParameters",
    "Picture",
    "Profile",
    "RsrsError",
    "Sweep",
    "SweepResult",
    "Table",
    "Trajectory",
    "Validation",
    "Verdict",
    "Worlds",
    "__version__",
    "answer",
    "compare",
    "diagnose",
    "episode",
    "explore",
    "fit",
    "judge",
    "report",
    "validate",
]


def __getattr__(name: str) -> Any:
    """Environments are looked for where they are asked for: what they need may not be there."""
    if name in ("parallel_env", "vector_env"):
        from . import environments

        return getattr(environments, name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
