"""Exact breathers of vibro-impact chains: which exist, which are physical, which are stable, and how stability is lost."""

from ._errors import (
    IllConditionedError,
    NoBreatherError,
    NotConvergedError,
    RequestError,
    ResonanceError,
    TooLargeError,
    VibrochainError,
)
from ._vibrochain import (
    Admissibility,
    Breathers,
    Chain,
    Completeness,
    Condition,
    Force,
    Impact,
    Model,
    Obstruction,
    Orbit,
    Stability,
    Verdict,
)
