"""Many protobuf messages of one kind, encoded at once: one by the library, the others by exchanging its numbers.

A message whose fields have the same presence and whose time stamp has the same length differs from its like in the
eight bytes of each double and in the varint of the nanoseconds alone. The result is byte for byte the library's.
"""

import struct
from collections.abc import Callable, Sequence

import numpy as np

from cycloid_mj.base.array import Array, Bytes, Integers, Mask
from cycloid_mj.base.protobuf import varint

Build = Callable[[Sequence[float], int], bytes]
"""Encodes one message from its doubles and its time stamp [ns]."""

SECOND = 1_000_000_000
NANOSECONDS_TAG = b"\x10"
"""Key of field 2 of ``google.protobuf.Timestamp``."""

SHORTEST_VARINT = 4
"""Bytes of nanoseconds from which on they are exchanged: shorter ones, of 2 ms after each second, are rare."""


def encode_messages(build: Build, values: Array, stamps: Integers) -> list[bytes]:
    """Return the messages of k rows of doubles (k, d) with time stamps (k,) [ns].

    `build` has to write every double of its argument that is not zero exactly once, and may write the time stamp any
    number of times as a ``google.protobuf.Timestamp``. Where it writes none, the stamps are zeros.
    """
    messages = [b""] * len(values)
    if not messages:
        return messages
    seconds, nanoseconds = np.divmod(stamps, SECOND)
    lengths = _varint_lengths(nanoseconds)
    present = values.view(np.int64) != 0  # protobuf leaves out +0.0 alone
    keys = np.column_stack([np.packbits(present, axis=1).astype(np.int64), seconds, lengths])
    _, first, group_of, sizes = np.unique(keys, axis=0, return_index=True, return_inverse=True, return_counts=True)
    rows_by_group = np.split(np.argsort(group_of.ravel(), kind="stable"), np.cumsum(sizes)[:-1])
    for row, rows in zip(first.tolist(), rows_by_group, strict=True):
        is_short = 0 < lengths[row] < SHORTEST_VARINT
        if len(rows) == 1 or is_short:
            for one in rows.tolist():
                messages[one] = build(values[one].tolist(), int(stamps[one]))
            continue
        filled = _fill(build, present[row], values[rows], int(seconds[row]), int(lengths[row]), nanoseconds[rows])
        size, content = filled.shape[1], filled.tobytes()
        for number, one in enumerate(rows.tolist()):
            messages[one] = content[number * size : (number + 1) * size]
    return messages


def _fill(build: Build, present: Mask, values: Array, second: int, length: int, nanoseconds: Integers) -> Bytes:
    """Return messages (k, size) of rows whose fields have one presence and whose nanoseconds have one length."""
    marks = np.where(present, 1000.0 + np.arange(len(present)) / 7.0, 0.0)
    nanosecond = (1 << 7 * (length - 1)) + 0x5A5A5 if length else 0
    template = build(marks.tolist(), SECOND * second + nanosecond)
    messages = np.tile(np.frombuffer(template, np.uint8), (len(values), 1))
    for column, mark in enumerate(marks.tolist()):
        if mark:
            (offset,) = _offsets(template, struct.pack("<d", mark))
            messages[:, offset : offset + 8] = values[:, column : column + 1].copy().view(np.uint8)
    if length:
        shift = 7 * np.arange(length)
        digits = (nanoseconds[:, np.newaxis] >> shift & 0x7F) | np.where(shift < shift[-1], 0x80, 0)
        for offset in _offsets(template, NANOSECONDS_TAG + varint(nanosecond)):
            messages[:, offset + 1 : offset + 1 + length] = digits
    return messages


def _offsets(content: bytes, part: bytes) -> list[int]:
    """Return where a part occurs in a content."""
    offsets, at = [], content.find(part)
    while at >= 0:
        offsets.append(at)
        at = content.find(part, at + len(part))
    return offsets


def _varint_lengths(values: Integers) -> Integers:
    """Return the bytes of each number as a varint; 0 of zero, which protobuf leaves out."""
    return np.searchsorted(np.array([1, *(1 << 7 * bytes_ for bytes_ in range(1, 5))]), values, side="right")
