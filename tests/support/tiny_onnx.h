// Writes ONNX files of a few nodes by hand, so that tests of network loaders need neither weights
// nor Python.
#pragma once

#include <cstdint>
#include <cstring>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace deepslam::testing_support {

// A network that looks at nothing: float inputs, and outputs whose values are fixed.
struct TinyNetwork {
  struct Tensor {
    std::vector<std::int64_t> shape;
    std::vector<float> values;
    std::string name = {};                        // empty: output0, output1 ...
    std::vector<std::int64_t> stated_shape = {};  // empty: the shape it has
  };
  struct Input {
    std::string name;
    std::vector<std::int64_t> shape;
  };
  std::vector<std::int64_t> input_shape = {1, 3, 64, 64};  // of the input `images` ...
  std::vector<Input> inputs = {};                          // ... unless there are others here
  std::vector<Tensor> outputs;
  std::map<std::string, std::string> metadata;
};

namespace tiny_onnx {

inline std::string Varint(std::uint64_t value) {
  std::string bytes;
  while (value >= 0x80) {
    bytes.push_back(static_cast<char>((value & 0x7F) | 0x80));
    value >>= 7;
  }
  bytes.push_back(static_cast<char>(value));
  return bytes;
}

inline std::string Number(int field, std::int64_t value) {
  std::string bytes = Varint(static_cast<std::uint64_t>(field) << 3);
  bytes += Varint(static_cast<std::uint64_t>(value));
  return bytes;
}

inline std::string Bytes(int field, std::string_view content) {
  std::string bytes = Varint((static_cast<std::uint64_t>(field) << 3) | 2);
  bytes += Varint(content.size());
  bytes += content;
  return bytes;
}

// ValueInfoProto of a float tensor; sides below 1 are left open.
inline std::string Value(const std::string& name, const std::vector<std::int64_t>& shape) {
  std::string dims;
  for (const std::int64_t side : shape) {
    dims += Bytes(1, side > 0 ? Number(1, side) : Bytes(2, "open"));
  }
  std::string tensor = Number(1, 1);
  tensor += Bytes(2, dims);
  std::string value = Bytes(1, name);
  value += Bytes(2, Bytes(1, tensor));
  return value;
}

}  // namespace tiny_onnx

inline std::string WriteOnnx(const TinyNetwork& network) {
  using tiny_onnx::Bytes;
  using tiny_onnx::Number;
  std::string graph;
  std::string initializers;
  std::string outputs;
  for (std::size_t i = 0; i < network.outputs.size(); ++i) {
    const TinyNetwork::Tensor& tensor = network.outputs[i];
    const std::string name = tensor.name.empty() ? "output" + std::to_string(i) : tensor.name;
    const std::string constant = "constant" + std::to_string(i);
    std::string node = Bytes(1, constant);
    node += Bytes(2, name);
    node += Bytes(4, "Identity");
    graph += Bytes(1, node);
    std::string initializer;
    for (const std::int64_t side : tensor.shape) initializer += Number(1, side);
    initializer += Number(2, 1);
    initializer += Bytes(8, constant);
    std::string raw(tensor.values.size() * sizeof(float), '\0');
    std::memcpy(raw.data(), tensor.values.data(), raw.size());
    initializer += Bytes(9, raw);
    initializers += Bytes(5, initializer);
    outputs += Bytes(
        12,
        tiny_onnx::Value(name, tensor.stated_shape.empty() ? tensor.shape : tensor.stated_shape));
  }
  graph += Bytes(2, "tiny");
  graph += initializers;
  if (network.inputs.empty()) graph += Bytes(11, tiny_onnx::Value("images", network.input_shape));
  for (const TinyNetwork::Input& input : network.inputs)
    graph += Bytes(11, tiny_onnx::Value(input.name, input.shape));
  graph += outputs;
  std::string model = Number(1, 8);
  model += Bytes(7, graph);
  model += Bytes(8, Number(2, 13));
  for (const auto& [key, value] : network.metadata) {
    std::string entry = Bytes(1, key);
    entry += Bytes(2, value);
    model += Bytes(14, entry);
  }
  return model;
}

}  // namespace deepslam::testing_support
