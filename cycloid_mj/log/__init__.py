"""Logs: a `Run` as an MCAP file that Foxglove, Rerun and every MCAP tool can open.

This text is the definition of the file format.

Format, version "1"
-------------------
A log is an MCAP file (https://mcap.dev/spec). Its records come in this order:

1. Metadata ``cycloid_mj``: ``{"format": "1"}``. An MCAP file without it was not written by this package.
2. Metadata ``provenance``: flat text -> text.
3. One attachment for each file kept with the run (``design.toml``, ``model.xml``, ...).
4. Chunks, zstd-compressed, each with complete samples of every group, written one by one: a killed process loses only
   the chunk that it was filling. The first chunk begins with the schemas and channels.
5. One attachment for each file that exists only after the run (``findings.json``).
6. Metadata ``cycloid_mj.end``: ``{"complete": "true" or "false", "note": text, "samples": count}``.
7. End of data with its CRC, summary and index, as MCAP has them.

Each group of columns is one channel: topic ``/output_pins``, protobuf message ``cycloid_mj.OutputPins``, one message
per sample. Groups are sampled at the same times, and a column name occurs in one group only. The messages of sample
i carry sequence number i (modulo 2**32) and log time = publish time = round(1e9 t) [ns].

A message is flat: field 1 is the double ``time`` t [s], fields 2, 3, ... are the columns, all doubles. Zeros are
written explicitly and fields in order, so every message of a channel has the same length and the same key bytes; a
packed numpy record of key bytes and ``<f8`` values *is* the encoder and the decoder. The schema is a serialized
FileDescriptorSet (proto3); the unit of each column is its comment there, and again in the channel's metadata under
``units``, as JSON name -> unit.

Channels without ``units`` in their metadata are for viewers: the reader ignores them, as it does records of other
kinds. A log from ``cycloid-mj simulate`` has ``/tf`` (``foxglove.FrameTransforms``), ``/scene/parts`` and
``/scene/forces`` (``foxglove.SceneUpdate``), described in ``cycloid_mj.scene.messages``. Their frames are those of
the first sample at or after each multiple of 1/rate; the rate [Hz] is in the channel's metadata under ``rate_hz``.
They follow from the columns, so a log loses nothing without them: `write` computes them anew.
"""

from cycloid_mj.log.encoding import FORMAT, ColumnGroup
from cycloid_mj.log.place import LogTakenError
from cycloid_mj.log.reader import Log, ViewerTopic, load, read
from cycloid_mj.log.viewer import Viewer
from cycloid_mj.log.writer import LogWriter, write

__all__ = [
    "FORMAT",
    "ColumnGroup",
    "Log",
    "LogTakenError",
    "LogWriter",
    "Viewer",
    "ViewerTopic",
    "load",
    "read",
    "write",
]
