"""Encoding of a group of columns: flat protobuf messages of doubles, all of the same length."""

import json
import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt
from google.protobuf.descriptor_pb2 import FieldDescriptorProto, FileDescriptorSet

from cycloid_mj.base.array import Array, Bytes
from cycloid_mj.base.errors import LogError
from cycloid_mj.base.protobuf import varint

FORMAT = "1"
PACKAGE = "cycloid_mj"
TIME = "time"
FIXED64 = 1  # protobuf's wire type of a double

_SNAKE = re.compile(r"[a-z][a-z0-9]*(_[a-z0-9]+)*")


@dataclass(frozen=True)
class ColumnGroup:
    """Columns that share a topic, with one message per sample.

    Attributes
    ----------
    topic
        Name of the channel, such as "/output_pins".
    units
        Column name -> unit, in the order of the message's fields 2, 3, ... (field 1 is the time).

    Raises
    ------
    LogError
        A name is not in snake_case, or a column is called "time".
    """

    topic: str
    units: Mapping[str, str]

    def __post_init__(self) -> None:
        """Raise LogError if the topic or a column name of this group of logged columns is invalid."""
        if not self.topic.startswith("/") or not _SNAKE.fullmatch(self.topic[1:]):
            raise LogError(
                f"log topic {self.topic!r} is not valid: use a slash followed by a name in lower-case letters, digits "
                "and underscores, such as /output_pins"
            )
        for name in self.units:
            if not _SNAKE.fullmatch(name) or name == TIME:
                raise LogError(
                    f"column {name!r} of {self.topic} is not valid: use lower-case letters, digits and underscores, "
                    "such as gear_angle, but not the name 'time'"
                )

    @property
    def message(self) -> str:
        """Full name of the protobuf message, such as "cycloid_mj.OutputPins"."""
        return f"{PACKAGE}.{''.join(word.capitalize() for word in self.topic[1:].split('_'))}"

    @property
    def fields(self) -> list[tuple[str, int, int]]:
        """Name, number and type of the fields of the message."""
        return [(name, number, FieldDescriptorProto.TYPE_DOUBLE) for number, name in enumerate((TIME, *self.units), 1)]

    @cached_property
    def offsets(self) -> npt.NDArray[np.intp]:
        """Offsets of the values in a message [bytes]."""
        return np.cumsum([len(_key(number)) + 8 for _, number, _ in self.fields]) - 8

    @cached_property
    def record(self) -> np.dtype[np.void]:
        """Packed record of a message, with the values as fields and gaps for the key bytes."""
        field_names, formats = [TIME, *self.units], ["<f8"] * self.offsets.size
        layout = {
            "names": field_names,
            "formats": formats,
            "offsets": self.offsets.tolist(),
            "itemsize": self.zeros.size,
        }
        return np.dtype(layout)  # type: ignore[call-overload]

    @cached_property
    def zeros(self) -> Bytes:
        """Message whose values are 0, shape (size,)."""
        return np.frombuffer(b"".join(_key(number) + bytes(8) for _, number, _ in self.fields), dtype=np.uint8)

    @cached_property
    def key_bytes(self) -> npt.NDArray[np.intp]:
        """Offsets of the key bytes in a message: all bytes except those of the values."""
        return np.setdiff1d(np.arange(self.zeros.size), self.offsets[:, np.newaxis] + np.arange(8))

    def encode(self, time: Array, values: Array) -> Bytes:
        """Return the log messages of k samples of a group of columns as bytes, shape (k, bytes of a message).

        `time` has shape (k,) [s], `values` has shape (k, columns).
        """
        messages = np.tile(self.zeros, (time.size, 1))
        records = messages.view(self.record)[:, 0]
        records[TIME] = time
        for column, name in enumerate(self.units):
            records[name] = values[:, column]
        return messages

    def decode(self, messages: Bytes) -> npt.NDArray[np.void]:
        """Return k log messages of a group as a structured array (k,) with the fields ``time`` and the column names.

        The array is a view of `messages`, which have shape (k, bytes of a message).

        Raises
        ------
        ValueError
            The length of the messages, or the numbers or types of their fields, are not those of this group.
        """
        if messages.shape[1] != self.zeros.size:
            raise ValueError(
                f"messages of the topic {self.topic} have {messages.shape[1]} bytes, but their schema defines "
                f"{self.zeros.size}"
            )
        if (messages[:, self.key_bytes] != self.zeros[self.key_bytes]).any():
            raise ValueError(f"messages of the topic {self.topic} have fields that differ from their schema")
        return messages.view(self.record)[:, 0]

    def schema(self) -> bytes:
        """Return the schema of a group's log messages: a serialized FileDescriptorSet (protobuf, descriptor.proto).

        Units are its comments. The path [4, 0, 2, i] of a comment is that of field i of the first message in the file.
        """
        file_set = FileDescriptorSet()
        package, name = self.message.split(".")
        file = file_set.file.add(name=f"{package}{self.topic}.proto", package=package, syntax="proto3")
        message = file.message_type.add(name=name)
        units = ("s", *self.units.values())
        for index, ((field, number, kind), unit) in enumerate(zip(self.fields, units, strict=True)):
            message.field.add(name=field, number=number, type=kind, label=FieldDescriptorProto.LABEL_OPTIONAL)
            comment = f" [{unit}]\n"
            file.source_code_info.location.add(path=[4, 0, 2, index], span=[index, 0, 0], trailing_comments=comment)
        return file_set.SerializeToString(deterministic=True)

    def metadata(self) -> dict[str, str]:
        """Return the metadata of the channel: the units."""
        return {"units": json.dumps(dict(self.units))}


def group_of(channel: Any, schema: Any) -> ColumnGroup:
    """Return the column group of a log that an MCAP channel and its schema describe.

    Raises
    ------
    ValueError
        The schema is not a flat message of doubles that starts with the time.
    Exception
        An error of protobuf or json about malformed text.
    """
    units = json.loads(channel.metadata["units"])
    (file,) = FileDescriptorSet.FromString(schema.data).file
    (message,) = file.message_type
    fields = [(field.name, field.number, field.type) for field in message.field]
    group = ColumnGroup(channel.topic, {name: str(units[name]) for name, _, _ in fields[1:]})
    if fields != group.fields or channel.message_encoding != "protobuf":
        raise ValueError(
            f"the schema of the topic {channel.topic} does not consist of the time followed by 64-bit numbers"
        )
    return group


def _key(field_number: int) -> bytes:
    """Encode the key of the field `field_number` as a double (protobuf encoding, "Message Structure")."""
    return varint(field_number << 3 | FIXED64)
