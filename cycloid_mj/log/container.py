"""Reader of the records of an MCAP file that checks each of them.

`mcap` writes the file and parses each record. Its `StreamReader` (1.6.0, November 2026) does not walk the file: it
ignores the CRC of attachments, reads on through records of no kind (200 s for each gigabyte of zeros, which a crashed
file system or a hostile file has), and inflates a chunk as far as its data say. Here a walk ends at the first header
that is invalid, and sizes and counts are checked before they take memory.
"""

import struct
import zlib
from collections import defaultdict
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import Any, BinaryIO

import lz4.frame
import numpy as np
import zstandard
from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.records import Attachment, Channel, Chunk, Metadata, Schema

from cycloid_mj.base.array import Bytes
from cycloid_mj.base.errors import LogError

MAGIC = b"\x89MCAP0\r\n"
HEAD = struct.Struct("<BQ")  # opcode, length of the content
MESSAGE_HEAD = np.dtype(
    [
        ("opcode", "u1"),
        ("length", "<u8"),
        ("channel", "<u2"),
        ("sequence", "<u4"),
        ("log_time", "<u8"),
        ("publish_time", "<u8"),
    ]
)
MIN_MESSAGE_LENGTH = MESSAGE_HEAD.itemsize - HEAD.size
"""Length of the content of a message without data [bytes]."""


@dataclass(frozen=True)
class ChunkLimits:
    """Limits of a chunk, which are checked before it takes memory."""

    max_size: int = 1 << 30
    """Largest size of a decompressed chunk [bytes]. Chunks of `LogWriter` have half a megabyte."""
    max_definitions: int = 1 << 17
    """Largest number of schemas and channels in a chunk: their ids have 16 bits each."""
    max_messages_per_byte: int = 4
    """Largest number of messages per byte of the compressed data.

    Sequence numbers and times differ from message to message. Chunks of constant columns, the most compressible content
    there is, have 0.1 (a single channel) to 0.7 (forty).
    """
    block_size: int = 1 << 20
    """Bytes that are inflated at a time to count messages."""


CHUNK = ChunkLimits()

_START_OF_MESSAGE = struct.Struct("<BQH")  # opcode, length, channel


@dataclass(frozen=True)
class Record:
    """A record of the file: its kind, its content, and its offset in the file [bytes]."""

    opcode: int
    content: bytes
    offset: int


@dataclass(frozen=True)
class Messages:
    """Content of a chunk: schemas and channels by id, and the messages of each channel.

    `rows` maps the id of a channel to its message records with their headers, shape (k, bytes of a record), in the
    order of the file; channels whose messages differ in length are in `ragged` instead. `counts` has the number of
    messages of each channel.
    """

    schemas: dict[int, Any]
    channels: dict[int, Any]
    rows: dict[int, Bytes]
    ragged: frozenset[int]
    counts: dict[int, int]


def corrupt_log_error(path: Path, problem: str) -> LogError:
    """Return the error for a damaged log."""
    return LogError(f"log {path} is corrupt: {problem}. Use an undamaged copy, or simulate the design again")


@contextmanager
def convert_parse_errors(path: Path, content: str) -> Iterator[None]:
    """Convert any exception inside this ``with`` block to a LogError about malformed content of a log."""
    try:
        yield
    except Exception as problem:
        reason = str(problem).splitlines()[0] if str(problem) else type(problem).__name__
        raise corrupt_log_error(path, f"{content} ({reason})") from problem


def read_records(stream: BinaryIO, path: Path) -> Iterator[Record]:
    """Yield the complete records of the data section of an MCAP file, in order, and verify the CRC of the section.

    The last record is DATA_END if and only if the file is complete; of a truncated file, the complete records remain.
    `stream` is the open file, `path` names it in errors.

    Raises
    ------
    LogError
        The file is not an MCAP file, or the CRC of its data is wrong.
    """
    file_size = stream.seek(0, 2)
    is_sealed = _has_seal(stream, file_size)
    stream.seek(0)
    if stream.read(len(MAGIC)) != MAGIC:
        raise LogError(
            f"{path} is not an MCAP file: choose a log that `cycloid-mj simulate` wrote, whose name ends in .mcap"
        )
    crc = zlib.crc32(MAGIC)
    while True:
        offset = stream.tell()
        header = stream.read(HEAD.size)
        opcode, length = HEAD.unpack(header) if len(header) == HEAD.size else (0, 0)
        # no record has opcode 0: these bytes were reserved but never written
        if opcode == 0 or length > file_size - stream.tell():
            break
        content = stream.read(length)
        if opcode == Opcode.DATA_END:
            _check_data_crc(content, crc, path)
            if is_sealed:
                yield Record(opcode, content, offset)
            return
        crc = zlib.crc32(content, zlib.crc32(header, crc))
        yield Record(opcode, content, offset)
    if is_sealed:
        raise corrupt_log_error(path, f"there is no valid record at byte {offset} of {file_size}")


def read_metadata(record: Record, path: Path) -> tuple[str, dict[str, str]]:
    """Read name and entries of a metadata record; raise LogError if it is malformed."""
    with convert_parse_errors(path, f"malformed metadata at byte {record.offset}"):
        parsed = Metadata.read(_stream(record.content))
    return parsed.name, parsed.metadata


def read_attachment(record: Record, path: Path) -> tuple[str, bytes]:
    """Read an attachment from its record, and verify its CRC; `path` names the file in errors.

    Returns
    -------
    tuple
        Name and content.

    Raises
    ------
    LogError
        The record is malformed, or its CRC is wrong.
    """
    with convert_parse_errors(path, f"malformed attachment at byte {record.offset}"):
        (crc,) = struct.unpack("<I", record.content[-4:])
        if zlib.crc32(record.content[:-4]) != crc:
            raise ValueError("its CRC is wrong")
        attachment = Attachment.read(_stream(record.content))
    return attachment.name, attachment.data


def read_chunk(record: Record, path: Path) -> Messages:
    """Read the schemas, channels and messages of a chunk record, and verify the CRC of the chunk.

    `path` names the file in errors.

    Raises
    ------
    LogError
        The chunk is malformed, its CRC is wrong, or it exceeds one of the limits in `CHUNK`.
    """
    with convert_parse_errors(path, f"malformed chunk at byte {record.offset}"):
        chunk = Chunk.read(_stream(record.content))
        _check_message_count(chunk)
        data = decompress(chunk.data, chunk.compression, chunk.uncompressed_size)
        if zlib.crc32(data) != chunk.uncompressed_crc:
            raise ValueError("its CRC is wrong")
        return _parse_chunk(data)


def _check_message_count(chunk: Chunk) -> None:
    """Refuse a chunk with more messages than its compressed data can describe, before memory is allocated for them.

    The compressed data are inflated block by block, and the record headers in them are counted. Chunks that are too
    small for that many messages are accepted without counting. Chunks larger than `CHUNK.max_size` are not counted
    either, because `decompress` refuses them. Counting ends without an error at an invalid header, which `_parse_chunk`
    reports.

    Raises
    ------
    ValueError
        There are more than `CHUNK.max_messages_per_byte` messages for each byte of the compressed data.
    """
    max_count = CHUNK.max_messages_per_byte * len(chunk.data)
    if chunk.uncompressed_size <= max_count * MESSAGE_HEAD.itemsize or chunk.uncompressed_size > CHUNK.max_size:
        return
    message_count, bytes_to_skip, remainder = 0, 0, b""
    stream = _open_decompressed(chunk.data, chunk.compression)
    while block := stream.read(CHUNK.block_size):
        if bytes_to_skip >= len(block):
            bytes_to_skip -= len(block)
            continue
        data, position = remainder + block, bytes_to_skip
        while position + HEAD.size <= len(data):
            opcode, length = HEAD.unpack_from(data, position)
            if not opcode:
                return
            position += HEAD.size + length
            message_count += 1
        if message_count > max_count:
            raise ValueError(f"it has more than {max_count:,} messages in {len(chunk.data):,} compressed bytes")
        remainder, bytes_to_skip = data[position:], max(0, position - len(data))


def _open_decompressed(data: bytes, compression: str) -> BinaryIO:
    """Return a stream that decompresses the data of a chunk; the compression is "zstd", "lz4" or "".

    Raises
    ------
    ValueError
        The compression is not supported.
    """
    if compression == "zstd":
        stream: BinaryIO = zstandard.ZstdDecompressor().stream_reader(data)
    elif compression == "lz4":
        stream = lz4.frame.LZ4FrameFile(BytesIO(data))
    elif not compression:
        stream = BytesIO(data)
    else:
        raise ValueError(f"its compression {compression!r} is not supported; zstd and lz4 are")
    return stream


def decompress(data: bytes, compression: str, size: int) -> bytes:
    """Decompress the `data` of a chunk, which states `size` bytes as its decompressed size.

    `compression` is "zstd", "lz4" or "". No more memory is allocated than for this size.

    Raises
    ------
    ValueError
        The stated size exceeds `CHUNK.max_size`, or the decompressed data have another size.
    Exception
        An error of zstandard or lz4 about malformed data.
    """
    if size > CHUNK.max_size:
        raise ValueError(f"its stated size is {size:,} bytes; the limit is {CHUNK.max_size:,}")
    with _open_decompressed(data, compression) as stream:
        content = stream.read(size + 1)
    if len(content) != size:
        raise ValueError(f"its size is not the stated {size:,} bytes")
    return content


def _parse_chunk(data: bytes) -> Messages:
    """Parse the records of a decompressed chunk, `data`, into schemas, channels, and messages of each channel.

    Raises
    ------
    ValueError
        A record is not a valid schema, channel or message.
    """
    schemas: dict[int, Any] = {}
    channels: dict[int, Any] = {}
    offsets_by_channel: dict[int, list[int]] = defaultdict(list)
    definition_count = 0
    position = 0
    while position < len(data):
        opcode, length, channel = _START_OF_MESSAGE.unpack_from(data, position)
        content_start = position + HEAD.size
        if opcode == Opcode.MESSAGE and length >= MIN_MESSAGE_LENGTH:
            offsets_by_channel[channel].append(position)
        elif opcode in (Opcode.SCHEMA, Opcode.CHANNEL) and definition_count < CHUNK.max_definitions:
            definitions_by_id, record_type = (schemas, Schema) if opcode == Opcode.SCHEMA else (channels, Channel)
            message = record_type.read(_stream(data[content_start : content_start + length]))
            definitions_by_id[message.id] = message
            definition_count += 1
        else:
            raise ValueError(f"there is no valid schema, channel or message at its byte {position}")
        position = content_start + length
    rows_by_channel = {
        channel: rows
        for channel, offsets in offsets_by_channel.items()
        if (rows := _equal_length_rows(data, offsets)) is not None
    }
    counts = {channel: len(offsets) for channel, offsets in offsets_by_channel.items()}
    return Messages(
        schemas, channels, rows_by_channel, frozenset(offsets_by_channel.keys() - rows_by_channel.keys()), counts
    )


def _equal_length_rows(data: bytes, offsets: list[int]) -> Bytes | None:
    """Return the message records at k byte offsets of a chunk, `data`, as an array, shape (k, bytes of a record).

    Return None if their lengths differ, or if a record is shorter than its header.
    """
    _, length = HEAD.unpack_from(data, offsets[0])
    record_size = HEAD.size + length
    if record_size < MESSAGE_HEAD.itemsize:
        return None
    rows = np.lib.stride_tricks.sliding_window_view(np.frombuffer(data, dtype=np.uint8), record_size)[offsets]
    headers = rows[:, : MESSAGE_HEAD.itemsize].view(MESSAGE_HEAD)
    return rows if (headers["length"] == length).all() else None


def _has_seal(stream: BinaryIO, file_size: int) -> bool:
    """Return whether a file of `file_size` bytes ends in the magic bytes, which are written when it is complete."""
    stream.seek(max(0, file_size - len(MAGIC)))
    return file_size >= 2 * len(MAGIC) and stream.read() == MAGIC


def _check_data_crc(content: bytes, crc: int, path: Path) -> None:
    with convert_parse_errors(path, "malformed end of data"):
        (expected,) = struct.unpack("<I", content)
    # by the specification of MCAP, 0 means that there is no CRC, as in logs that other tools repacked
    if expected not in (0, crc):
        raise corrupt_log_error(path, "the CRC of its data is wrong")


def _stream(content: bytes) -> ReadDataStream:
    return ReadDataStream(BytesIO(content))
