"""What the node publishes beside its telemetry, at rates of its own, and never records: clock, pictures."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import isinf

from haul_ros.messages.cdr import CLOCK, encode_clock
from haul_ros.messages.channels import EVENT, LATCHED, STRING, Channel
from haul_ros.messages.encoder import Message
from haul_ros.messages.force_image import IMAGE, ForceImage
from haul_ros.messages.train_markers import MARKERS, TrainMarkers
from haul_ros.model.consist import Consist
from haul_ros.model.sample import Sample
from haul_ros.units import NS_PER_S

CLOCK_CHANNEL = Channel("/clock", CLOCK, EVENT._replace(depth=1))


def state_channel(prefix: str) -> Channel:
    """What the node of this full name does: ``compiling``, ``running``, ``paused`` or ``ended``."""
    return Channel(f"{prefix}/state", STRING, LATCHED)


@dataclass(frozen=True, slots=True)
class UnrecordedRates:
    """Rates [Hz] in simulation time; 0: not at all. Above that of the samples, also infinite: with every sample."""

    clock: float = 0.0
    force_image: float = 0.0
    train_markers: float = 0.0


class Unrecorded:
    """Clock, rolling picture of forces and coloured train of one run, each where it has a rate.

    ``prefix`` is the full name of the node, and without its first slash the frame of the pictures; ``force_limit``
    tells the force [N] at which their colours end.
    """

    def __init__(self, consist: Consist, prefix: str, rates: UnrecordedRates, force_limit: Callable[[], float]) -> None:
        self._frame = prefix.lstrip("/")
        self._force_limit = force_limit
        self._image: ForceImage | None = None
        self._made: list[tuple[_Rate, Channel, Callable[[Sample], bytes]]] = []
        if rates.clock:
            self._made.append((_Rate(rates.clock), CLOCK_CHANNEL, lambda sample: encode_clock(sample.time_ns)))
        if rates.force_image:
            self._image = image = ForceImage(len(consist.couplers))
            channel = Channel(f"{prefix}/force_image", IMAGE, EVENT._replace(depth=1))
            self._made.append((_Rate(rates.force_image), channel, lambda sample: self._scrolled(image, sample)))
        if rates.train_markers:
            markers = TrainMarkers(consist)
            channel = Channel(f"{prefix}/train_markers", MARKERS, EVENT._replace(depth=1))
            self._made.append((_Rate(rates.train_markers), channel, lambda sample: self._coloured(markers, sample)))

    @property
    def channels(self) -> tuple[Channel, ...]:
        """Of what has a rate."""
        return tuple(channel for _, channel, _ in self._made)

    def messages(self, sample: Sample) -> list[Message]:
        """What is due with a sample."""
        if self._image is not None:
            self._image.add(sample.coupler_force)
        time_ns = sample.time_ns
        return [Message(channel, time_ns, make(sample)) for rate, channel, make in self._made if rate.is_due(time_ns)]

    def _scrolled(self, image: ForceImage, sample: Sample) -> bytes:
        return image.scroll(sample.time_ns, self._frame, self._force_limit())

    def _coloured(self, markers: TrainMarkers, sample: Sample) -> bytes:
        return markers.encode(sample, self._frame, self._force_limit())


class _Rate:
    """Due at the first sample at or after each multiple of the period."""

    def __init__(self, rate: float) -> None:
        self._rate = rate
        self._periods = -1.0

    def is_due(self, time_ns: int) -> bool:
        # A sample that is due exactly now must not be missed for the rounding of its time to nanoseconds
        periods = (time_ns + 1) * self._rate // NS_PER_S
        due = periods > self._periods
        self._periods = periods
        return due or isinf(self._rate)
