"""Why there is no answer."""

from __future__ import annotations


class VibrochainError(Exception):
    """Base of all errors of this package; raised itself only where no other fits."""


class RequestError(VibrochainError, ValueError):
    """The request is wrong: a value out of range, an unknown name. The message says which value, what range, what to give."""


class NoBreatherError(VibrochainError):
    """There is no such breather here; the message says why."""


class ResonanceError(VibrochainError):
    """A harmonic of omega meets a mode of the lattice: no periodic motion is defined.

    Attributes
    ----------
    harmonic : int
        The number of the harmonic.
    mode : int
        The number of the mode.
    frequency : float
        The frequency of the mode.
    distance : float
        How far the harmonic is from it, as far as that can be resolved.
    """

    def __init__(
        self,
        message: str,
        harmonic: int | None = None,
        mode: int | None = None,
        frequency: float | None = None,
        distance: float | None = None,
    ) -> None:
        super().__init__(message, harmonic, mode, frequency, distance)
        self.harmonic, self.mode, self.frequency, self.distance = harmonic, mode, frequency, distance

    def __str__(self) -> str:
        return str(self.args[0])


class NotConvergedError(VibrochainError):
    """An iteration did not converge, or a run could not be completed."""


class IllConditionedError(VibrochainError):
    """An impact grazes: the answer is not finite there."""


class TooLargeError(VibrochainError):
    """The answer would take more time or memory than is ever spent."""
