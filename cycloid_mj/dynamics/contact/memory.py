"""Reads and writes at plain addresses, for compiled code that works on MuJoCo's own structures."""

from typing import Any

from numba import carray, njit, types
from numba.extending import intrinsic


def _make_reader(number_type: types.Number, name: str) -> Any:
    """Return a compiled function, called `name`, that reads a number of the type `number_type` at a memory address."""

    def read(typing_context: Any, address: types.Integer) -> Any:
        def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
            pointer = builder.inttoptr(args[0], context.get_data_type(number_type).as_pointer())
            return builder.load(pointer, align=1)

        return number_type(types.intp), codegen

    read.__name__ = read.__qualname__ = name
    return intrinsic(read)


read_float = _make_reader(types.float64, "read_float")
read_int = _make_reader(types.int32, "read_int")
read_address = _make_reader(types.intp, "read_address")


def make_pointer_cast(kind: types.Type) -> Any:
    """Return a compiled function that casts a memory address to a pointer to values of the numba type `kind`."""

    def pointer(typing_context: Any, address: types.Integer) -> Any:
        def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
            return builder.inttoptr(args[0], context.get_value_type(signature.return_type))

        return types.CPointer(kind)(types.intp), codegen

    return intrinsic(pointer)


_to_float = make_pointer_cast(types.float64)


@njit(inline="always")
def array_at(address: int, rows: int, columns: int) -> Any:
    """Return the numbers at an address as an array (rows, columns) that is a view on them."""
    return carray(_to_float(address), (rows, columns))


def _make_writer(number_type: types.Number, name: str) -> Any:
    """Return a compiled function, called `name`, that writes a number of the type `number_type` at a memory address."""

    def write(typing_context: Any, address: types.Integer, value: types.Number) -> Any:
        def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
            pointer = builder.inttoptr(args[0], context.get_data_type(number_type).as_pointer())
            builder.store(args[1], pointer, align=1)

        return types.void(types.intp, number_type), codegen

    write.__name__ = write.__qualname__ = name
    return intrinsic(write)


write_float = _make_writer(types.float64, "write_float")
