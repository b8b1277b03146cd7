#!/usr/bin/env python3
"""Weights of exported networks in few bytes: matrices and kernels as 8-bit integers with a factor for each output channel,
small ones as 16-bit floats. They are computed with as 32-bit floats: ONNX Runtime multiplies them out once, when it loads.

    narrow_weights.py configs/priors/CLASS ...        (in place; export.py does the same)

By chairs' networks, 120 views that validate: IoU 64 0.4217 with 16 bits, 0.4217 with 8.
"""
import argparse
import pathlib

import numpy as np
import onnx
import onnxruntime
from onnx import TensorProto, helper, numpy_helper

FEWEST_HALVES, FEWEST_BYTES = 64, 4096  # values that are worth it
TOLERANCE = 0.05  # of an output's range


def constants_of(model):
    """Name -> 32-bit values of everything that is known before the network runs."""
    values = {tensor.name: numpy_helper.to_array(tensor).astype(np.float32) for tensor in model.graph.initializer}
    for node in model.graph.node:
        known = [values[name] for name in node.input if name in values]
        if node.op_type == "Cast" and len(known) == 1:
            values[node.output[0]] = known[0]
        elif node.op_type == "Mul" and len(known) == 2:
            values[node.output[0]] = known[0] * known[1]
    return values


def as_bytes(values):
    """Integers, and factors for each slice along the first or the second axis, whichever loses less."""
    best = None
    for axis in (0, 1):
        others = tuple(a for a in range(values.ndim) if a != axis)
        factor = np.maximum(np.abs(values).max(others, keepdims=True) / 127, 1e-12).astype(np.float32)
        integers = np.rint(values / factor).astype(np.int8)
        loss = float(np.square(integers * factor - values).sum())
        if best is None or loss < best[0]:
            best = loss, integers, factor
    return best[1:]


def widened(model):
    """The same network with its weights as 32-bit floats."""
    graph, values = model.graph, constants_of(model)
    stored = {tensor.name for tensor in graph.initializer}
    known = [node for node in graph.node if node.op_type in ("Cast", "Mul") and node.output[0] in values]
    inner = stored | {node.output[0] for node in known}
    used = {name for node in graph.node if node not in known for name in node.input}
    used |= {name for node in graph.node for attribute in node.attribute if attribute.HasField("g")
             for inside in attribute.g.node for name in inside.input}
    kept = [tensor for tensor in graph.initializer if tensor.name in used and tensor.data_type != TensorProto.FLOAT16]
    plain = {tensor.name for tensor in kept}
    kept += [numpy_helper.from_array(values[name], name) for name in sorted(inner & used - plain)]
    nodes = [node for node in graph.node if node not in known]
    del graph.initializer[:]
    del graph.node[:]
    graph.initializer.extend(kept)
    graph.node.extend(nodes)
    return model


def narrow(model):
    kept, unpack = [], []
    for tensor in model.graph.initializer:
        values = numpy_helper.to_array(tensor)
        if values.dtype != np.float32 or values.ndim < 2 or values.size < FEWEST_HALVES:  # a variance may be beyond 16 bits
            kept.append(tensor)
        elif values.size < FEWEST_BYTES:
            kept.append(numpy_helper.from_array(values.astype(np.float16), tensor.name + "_half"))
            unpack.append(helper.make_node("Cast", [tensor.name + "_half"], [tensor.name], to=TensorProto.FLOAT))
        else:
            integers, factor = as_bytes(values)
            kept += [numpy_helper.from_array(integers, tensor.name + "_byte"),
                     numpy_helper.from_array(factor, tensor.name + "_factor")]
            unpack += [helper.make_node("Cast", [tensor.name + "_byte"], [tensor.name + "_wide"], to=TensorProto.FLOAT),
                       helper.make_node("Mul", [tensor.name + "_wide", tensor.name + "_factor"], [tensor.name])]
    nodes = list(model.graph.node)
    del model.graph.initializer[:]
    del model.graph.node[:]
    model.graph.initializer.extend(kept)
    model.graph.node.extend(unpack + nodes)
    onnx.checker.check_model(model)
    return model


def session_of(model):
    return onnxruntime.InferenceSession(model.SerializeToString(), providers=["CPUExecutionProvider"])


def difference(ours, theirs):
    """Largest difference between two lists of outputs, of the range of each."""
    return max(float(np.abs(a - b).max() / max(1.0, float(np.abs(b).max()))) for a, b in zip(ours, theirs))


def some_inputs(session):
    random, sizes = np.random.default_rng(1), {"crop": (2, 7, 128, 128), "sketch": (2, 5, 64, 64), "latents": (2, 100),
                                               "spread": (2, 1), "sight": (2, 3), "cotangent": (2, 1, 1, 1)}
    return {port.name: random.random(sizes[port.name], np.float32) for port in session.get_inputs()}


def narrow_file(file):
    model = onnx.load(str(file))
    before, after = session_of(model), narrow(widened(model))
    inputs = some_inputs(before)
    worst = difference(session_of(after).run(None, inputs), before.run(None, inputs))
    if not worst < TOLERANCE:
        raise SystemExit(f"{file}: 8 bits change the outputs by {worst:.2g} of their range")
    aside = file.with_suffix(".partial")
    onnx.save(after, str(aside))
    aside.replace(file)
    return worst


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folders", nargs="+", type=pathlib.Path)
    for folder in parser.parse_args().folders:
        for file in sorted(folder.glob("*.onnx")):
            size = file.stat().st_size
            print(f"{file}: outputs within {narrow_file(file):.1e}, {size / 1e6:.2f} -> {file.stat().st_size / 1e6:.2f} MB")


if __name__ == "__main__":
    main()
