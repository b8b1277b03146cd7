#!/usr/bin/env python3
"""A decoder that also tells its derivative: for the refinement of latents against depth.

    decoder_gradient.py decoder.onnx ...        (in place; export.py does the same)

Beside latents -> logits the network gets an input `cotangent` [N, 64, 64, 64], the derivative of a loss by the logits,
and an output `latent_gradient` [N, 100], the derivative of that loss by the latents. The weights are those of the
decoder: the file grows by 3 kB. A cotangent of any other shape (one number will do) asks for the logits alone.
"""
import argparse

import numpy as np
import onnx
import onnxruntime
from onnx import TensorProto, helper, numpy_helper

GRID, LATENTS = 64, 100
VERSION = 2


class Backward:
    """The nodes that carry a derivative from a network's output back to its input."""

    def __init__(self):
        self.nodes = []

    def add(self, kind, inputs, **attributes):
        name = f"gradient_{len(self.nodes)}"
        self.nodes.append(helper.make_node(kind, inputs, [name], **attributes))
        return name

    def constant(self, value):
        name = f"gradient_{len(self.nodes)}"
        self.nodes.append(helper.make_node("Constant", [], [name], value=numpy_helper.from_array(value)))
        return name

    def through(self, node, gradient):
        """The derivative by a node's input, given that by its output."""
        attributes = {a.name: helper.get_attribute_value(a) for a in node.attribute}
        if node.op_type == "ConvTranspose":
            same = {name: attributes[name] for name in ("kernel_shape", "strides", "pads", "dilations", "group")
                    if name in attributes}
            return self.add("Conv", [gradient, node.input[1]], **same)
        if node.op_type == "BatchNormalization":
            epsilon = self.constant(np.float32(attributes.get("epsilon", 1e-5)))
            deviation = self.add("Sqrt", [self.add("Add", [node.input[4], epsilon])])
            factor = self.add("Div", [node.input[1], deviation])
            shape = self.constant(np.array([1, -1, 1, 1], np.int64))
            return self.add("Mul", [gradient, self.add("Reshape", [factor, shape])])
        if node.op_type == "Relu":
            passed = self.add("Greater", [node.output[0], self.constant(np.float32(0))])
            return self.add("Mul", [gradient, self.add("Cast", [passed], to=TensorProto.FLOAT)])
        if node.op_type == "Reshape":
            return self.add("Flatten", [gradient], axis=1)
        if node.op_type == "Gemm" and attributes.get("transB") == 1:
            return self.add("MatMul", [gradient, node.input[1]])
        raise SystemExit(f"no derivative is known of a node {node.op_type}")


def chain(graph):
    """The nodes from the latents to the logits; each has the one before as its first input."""
    makers = {output: node for node in graph.node for output in node.output}
    nodes, at = [], "logits"
    while at != "latents":
        nodes.append(makers[at])
        at = nodes[-1].input[0]
    return nodes[::-1]


def with_gradient(model):
    graph = model.graph
    if any(value.name == "cotangent" for value in graph.input):
        return model
    backward = Backward()
    gradient = "cotangent"
    for node in reversed(chain(graph)):
        gradient = backward.through(node, gradient)
    output = lambda name: helper.make_tensor_value_info(name, TensorProto.FLOAT, ["batch", LATENTS])
    asked = helper.make_graph(backward.nodes, "derivative", [], [output(gradient)])
    zero = helper.make_tensor("value", TensorProto.FLOAT, [1], [0.0])
    empty = helper.make_graph(
        [helper.make_node("Constant", [], ["no_gradient_shape"],
                          value=numpy_helper.from_array(np.array([1, LATENTS], np.int64))),
         helper.make_node("ConstantOfShape", ["no_gradient_shape"], ["no_gradient"], value=zero)],
        "nothing", [], [output("no_gradient")])
    whole = numpy_helper.from_array(np.int64(GRID ** 3), "cotangent_values")
    graph.initializer.append(whole)
    graph.node.extend([
        helper.make_node("Shape", ["cotangent"], ["cotangent_shape"], start=1),
        helper.make_node("ReduceProd", ["cotangent_shape"], ["cotangent_size"], keepdims=0),
        helper.make_node("Equal", ["cotangent_size", "cotangent_values"], ["is_gradient_asked"]),
        helper.make_node("If", ["is_gradient_asked"], ["latent_gradient"], then_branch=asked, else_branch=empty)])
    graph.input.append(helper.make_tensor_value_info("cotangent", TensorProto.FLOAT, ["batch", "planes", "rows", "columns"]))
    graph.output.append(output("latent_gradient"))
    for entry in model.metadata_props:
        if entry.key == "version":
            entry.value = str(VERSION)
    onnx.checker.check_model(model)
    return model


def check(session):
    """Derivatives along random directions against differences of a smooth loss."""
    random = np.random.default_rng(1)
    latents = random.normal(0, 2, (1, LATENTS)).astype(np.float32)
    nothing = np.zeros((1, 1, 1, 1), np.float32)
    decode = lambda z: session.run(["logits"], {"latents": z, "cotangent": nothing})[0].astype(np.float64)
    loss = lambda z: float(np.log1p(np.exp(-np.abs(decode(z)))).mean() + np.maximum(decode(z), 0).mean())
    cotangent = (1 / (1 + np.exp(-decode(latents))) / GRID ** 3).astype(np.float32)
    gradient = session.run(["latent_gradient"], {"latents": latents, "cotangent": cotangent})[0][0]
    worst = 0.0
    for _ in range(8):
        direction = random.normal(0, 1, latents.shape).astype(np.float32)
        step = 2e-3
        slope = (loss(latents + step * direction) - loss(latents - step * direction)) / (2 * step)
        expected = float(direction[0] @ gradient)
        worst = max(worst, abs(slope - expected) / max(abs(slope), float(np.linalg.norm(gradient))))
    if not worst < 0.05:
        raise SystemExit(f"the derivative differs from differences by {worst:.2g} of itself")
    return worst


def add_to(file):
    model = with_gradient(onnx.load(str(file)))
    session = onnxruntime.InferenceSession(model.SerializeToString(), providers=["CPUExecutionProvider"])
    worst = check(session)
    onnx.save(model, str(file))
    return worst


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("decoders", nargs="+", metavar="decoder.onnx")
    for file in parser.parse_args().decoders:
        print(f"{file}: derivative within {add_to(file):.1e} of differences")


if __name__ == "__main__":
    main()
