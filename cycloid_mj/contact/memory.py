"""Reads and writes at plain addresses, for compiled code that works on MuJoCo's own structures."""

from typing import Any

from llvmlite import ir
from numba import types
from numba.extending import intrinsic


def _reader(number: types.Number, name: str) -> Any:
    def read(typing_context: Any, address: types.Integer) -> Any:
        def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
            pointer = builder.inttoptr(args[0], context.get_data_type(number).as_pointer())
            return builder.load(pointer, align=1)

        return number(types.intp), codegen

    read.__name__ = read.__qualname__ = name
    return intrinsic(read)


read_float = _reader(types.float64, "read_float")
read_int = _reader(types.int32, "read_int")
read_address = _reader(types.intp, "read_address")


@intrinsic
def write_float(typing_context: Any, address: types.Integer, value: types.Float) -> Any:
    """Store a double at an address."""

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        pointer = builder.inttoptr(args[0], ir.DoubleType().as_pointer())
        builder.store(args[1], pointer, align=1)

    return types.void(types.intp, types.float64), codegen
