"""Parts of the protobuf encoding that are written without the library, for many messages at once."""


def varint(value: int) -> bytes:
    """Encode a number of 7 bits a byte, the lowest first (protobuf encoding, "Base 128 Varints")."""
    groups = [value >> shift & 0x7F for shift in range(0, max(value.bit_length(), 1), 7)]
    return bytes([*(group | 0x80 for group in groups[:-1]), groups[-1]])
