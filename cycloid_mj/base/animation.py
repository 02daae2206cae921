"""Defaults and limits of an animation, which help texts state without loading matplotlib."""

from dataclasses import dataclass


@dataclass(frozen=True)
class AnimationSettings:
    """Size and frame rate of an animation."""

    frames: int = 90
    """Largest number of frames."""
    width: int = 640
    widths: tuple[int, int] = (200, 4000)
    """Width [px], and its range."""
    rate: int = 25
    rates: tuple[int, int] = (1, 50)
    """Frames per second, and their range: GIF counts hundredths of a second, and viewers slow down faster files."""


ANIMATION = AnimationSettings()
