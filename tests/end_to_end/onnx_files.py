"""ONNX files from protocol buffers by hand, field by field: networks of a few nodes, without the onnx package."""
import struct

FLOAT, INT64 = 1, 7  # ONNX's numbers of types


def _varint(value):
    data = b""
    while value > 127:
        data, value = data + bytes([value & 127 | 128]), value >> 7
    return data + bytes([value])


def _number(field, value):
    return _varint(field << 3) + _varint(value)


def _block(field, data):
    data = data.encode() if isinstance(data, str) else data
    return _varint(field << 3 | 2) + _varint(len(data)) + data


def _port(name, shape):
    dimensions = b"".join(_block(1, _number(1, side)) for side in shape)
    return _block(1, name) + _block(2, _block(1, _number(1, FLOAT) + _block(2, dimensions)))


def constant(name, shape, values, kind=FLOAT):
    raw = struct.pack(f"<{len(values)}{'f' if kind == FLOAT else 'q'}", *values)
    return b"".join(_number(1, side) for side in shape) + _number(2, kind) + _block(8, name) + _block(9, raw)


def node(operator, inputs, output):
    return b"".join(_block(1, name) for name in inputs) + _block(2, output) + _block(4, operator)


def network(inputs, outputs, nodes, constants=(), metadata=None):
    """The bytes of a file; `inputs` and `outputs`: name -> shape."""
    graph = b"".join(_block(1, one) for one in nodes) + _block(2, "g") + b"".join(_block(5, one) for one in constants)
    graph += b"".join(_block(11, _port(*one)) for one in inputs.items())
    graph += b"".join(_block(12, _port(*one)) for one in outputs.items())
    return _number(1, 8) + _block(7, graph) + _block(8, _number(2, 13)) + b"".join(
        _block(14, _block(1, key) + _block(2, str(value))) for key, value in (metadata or {}).items())
