"""What is written many messages at once is, byte for byte, what mcap's own writer makes of one after another."""

from io import BytesIO

import numpy as np
from mcap.writer import Writer

from cycloid_mj.log.blocks import BlockWriter, ChannelMessage


def test_blocks_are_the_bytes_of_mcaps_own_writer() -> None:
    ours, theirs = BytesIO(), BytesIO()
    block, single = BlockWriter(ours, "made here"), Writer(theirs, chunk_size=1 << 62, enable_data_crcs=True)
    single.start(library="made here")
    for writer in (block, single):
        writer.add_metadata("run", {"design": "pin", "note": "\u00b5m"})
    block.add_attachment("design.toml", "application/toml", b"name")
    single.add_attachment(0, 0, "design.toml", "application/toml", b"name")
    channels = []
    for topic in ("/a", "/b", "/scene"):
        channels.append(block.add_channel(topic, block.add_schema(topic[1:], b"schema"), {"units": "{}"}))
        schema = single.register_schema(topic[1:], "protobuf", b"schema")
        assert single.register_channel(topic, "protobuf", schema, {"units": "{}"}) == channels[-1]
    random, sequence = np.random.default_rng(3), 0xFFFFFFFE
    for chunk in range(3):
        times = (np.arange(5) + 5 * chunk + 1).astype(np.uint64) * 100
        contents = [random.integers(0, 256, (5, size)).astype(np.uint8) for size in (18, 7)]
        single.add_message(channels[2], int(times[0]), b"shown", int(times[0]), 2 * chunk)
        shown = ChannelMessage(channels[2], int(times[0]), 2 * chunk, b"shown")
        later = ChannelMessage(channels[2], int(times[3]), 2 * chunk + 1, b"later")
        block.add_message(shown)
        block.add_samples(channels[:2], times, sequence, contents, {3: [later]})
        for row, time in enumerate(times.tolist()):
            if row == 3:
                single.add_message(channels[2], time, b"later", time, 2 * chunk + 1)
            for channel, content in zip(channels[:2], contents, strict=True):
                single.add_message(channel, time, content[row].tobytes(), time, (sequence + row) & 0xFFFFFFFF)
        sequence += 5
        for _ in range(2):
            block.flush()
            single.flush()
    for writer in (block, single):
        writer.add_metadata("end", {"complete": "true"})
        writer.finish()
    assert ours.getvalue() == theirs.getvalue()
