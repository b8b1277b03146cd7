// Writes a detector as an ONNX file that looks at its input: a cell of the grids with strides 8, 16
// and 32 is an object of class red, green or blue where its pixels are. Sides are noted in it as
// exports of the YOLO family note them.
#pragma once

#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <vector>

#include "support/tiny_onnx.h"

namespace deepslam::testing_support {

struct GridNetwork {
  int width = 128;
  int height = 128;
  enum class Constants { kInitializers, kNodes, kListed } constants = Constants::kInitializers;
  bool cells_by_columns = false;  // cells in another order than that of the family
  bool expands = false;           // sides in the target of an Expand as well
};

namespace grid_onnx {

using tiny_onnx::Bytes;
using tiny_onnx::Number;

// What a graph is made of, in the order in which it is added.
class Graph {
 public:
  explicit Graph(GridNetwork::Constants constants) : constants_(constants) {}

  void Node(const std::string& type,
            const std::vector<std::string>& inputs,
            const std::string& output,
            const std::string& attributes = {}) {
    std::string node;
    for (const std::string& input : inputs) node += Bytes(1, input);
    node += Bytes(2, output) + Bytes(4, type) + attributes;
    nodes_ += Bytes(1, node);
  }

  void Integers(const std::string& name, const std::vector<std::int64_t>& values) {
    const std::vector<std::int64_t> dims = {static_cast<std::int64_t>(values.size())};
    if (constants_ != GridNetwork::Constants::kListed)
      return Constant(name, dims, 7, Bytes(9, Raw<std::int64_t>(values)));
    std::string packed;
    for (const std::int64_t value : values)
      packed += tiny_onnx::Varint(static_cast<std::uint64_t>(value));
    Constant(name, dims, 7, Bytes(7, packed));
  }

  void Floats(const std::string& name,
              const std::vector<std::int64_t>& dims,
              const std::vector<float>& values) {
    const int field = constants_ == GridNetwork::Constants::kListed ? 4 : 9;
    Constant(name, dims, 1, Bytes(field, Raw<float>(values)));
  }

  [[nodiscard]] std::string text() const { return nodes_ + initializers_; }

 private:
  template <typename T>
  static std::string Raw(std::span<const T> values) {
    std::string raw(values.size_bytes(), '\0');
    if (!values.empty()) std::memcpy(raw.data(), values.data(), raw.size());
    return raw;
  }

  void Constant(const std::string& name,
                const std::vector<std::int64_t>& dims,
                int type,
                const std::string& data) {
    std::string tensor;
    for (const std::int64_t side : dims) tensor += Number(1, side);
    tensor += Number(2, type) + data;
    if (constants_ == GridNetwork::Constants::kNodes) {
      Node("Constant", {}, name, Bytes(5, Bytes(1, "value") + Bytes(5, tensor) + Number(20, 4)));
    } else {
      initializers_ += Bytes(5, tensor + Bytes(8, name));
    }
  }

  GridNetwork::Constants constants_;
  std::string nodes_;
  std::string initializers_;
};

inline std::string Ints(const std::string& name, const std::vector<std::int64_t>& values) {
  std::string attribute = Bytes(1, name);
  for (const std::int64_t value : values) attribute += Number(8, value);
  return Bytes(5, attribute + Number(20, 7));
}

inline std::string Int(const std::string& name, std::int64_t value) {
  return Bytes(5, Bytes(1, name) + Number(3, value) + Number(20, 2));
}

// Mean colours of the cells, 1 x 3 x N.
inline void AddColours(const GridNetwork& network, Graph& graph) {
  for (const int stride : {8, 16, 32}) {
    const std::string s = std::to_string(stride);
    graph.Node("AveragePool",
               {"images"},
               "grid" + s,
               Ints("kernel_shape", {stride, stride}) + Ints("strides", {stride, stride}));
    graph.Integers(
        "flat_shape" + s,
        {1, 3, static_cast<std::int64_t>(network.width / stride) * (network.height / stride)});
  }
  // There and back again, as attention and upsampling do it.
  graph.Integers("square_shape", {1, 3, network.height / 32, network.width / 32});
  graph.Node("Reshape", {"grid32", "flat_shape32"}, "attended");
  graph.Node("Reshape", {"attended", "square_shape"}, "again32");
  graph.Integers("upsampled_shape", {1, 3, network.height / 16, network.width / 16});
  graph.Node("Resize", {"again32", "", "", "upsampled_shape"}, "upsampled");
  graph.Node("Max", {"grid16", "upsampled"}, "again16");
  graph.Node("Reshape", {"grid8", "flat_shape8"}, "flat8");
  graph.Node("Reshape", {"again16", "flat_shape16"}, "flat16");
  graph.Node("Reshape", {"again32", "flat_shape32"}, "flat32");
  graph.Node("Concat", {"flat8", "flat16", "flat32"}, "colours", Int("axis", 2));
}

// Where the cells lie, 1 x 2 x N, in strides, and their strides, 1 x N.
inline void AddTables(const GridNetwork& network, Graph& graph) {
  std::vector<float> u_cells;
  std::vector<float> v_cells;
  std::vector<float> strides;
  for (const int stride : {8, 16, 32}) {
    const int width = network.width / stride;
    const int num_cells = width * (network.height / stride);
    for (int n = 0; n < num_cells; ++n) {
      const int height = num_cells / width;
      const int u = network.cells_by_columns ? n / height : n % width;
      const int v = network.cells_by_columns ? n % height : n / width;
      u_cells.push_back(static_cast<float>(u) + 0.5F);
      v_cells.push_back(static_cast<float>(v) + 0.5F);
      strides.push_back(static_cast<float>(stride));
    }
  }
  const auto num_cells = static_cast<std::int64_t>(strides.size());
  std::vector<float> places = u_cells;
  places.insert(places.end(), v_cells.begin(), v_cells.end());
  graph.Floats("places", {1, 2, num_cells}, places);
  graph.Floats("strides", {1, num_cells}, strides);
  graph.Floats("ones", {1, 2, 1}, {1, 1});
  if (network.expands) graph.Integers("expanded_shape", {1, 2, num_cells});
}

}  // namespace grid_onnx

inline std::string WriteOnnx(const GridNetwork& network) {
  using tiny_onnx::Bytes;
  using tiny_onnx::Number;
  grid_onnx::Graph parts(network.constants);
  grid_onnx::AddTables(network, parts);
  grid_onnx::AddColours(network, parts);
  parts.Node("Mul", {"places", "strides"}, "centres");
  parts.Node("Mul", {"ones", "strides"}, "sides");
  if (network.expands) parts.Node("Expand", {"sides", "expanded_shape"}, "expanded");
  parts.Node("Concat",
             {"centres", network.expands ? "expanded" : "sides", "colours"},
             "output0",
             grid_onnx::Int("axis", 1));
  std::int64_t num_cells = 0;
  for (const int stride : {8, 16, 32})
    num_cells += static_cast<std::int64_t>(network.width / stride) * (network.height / stride);
  const std::string graph =
      parts.text() + Bytes(2, "grid") +
      Bytes(11, tiny_onnx::Value("images", {1, 3, network.height, network.width})) +
      Bytes(12, tiny_onnx::Value("output0", {1, 7, num_cells}));
  return Number(1, 8) + Bytes(7, graph) + Bytes(8, Number(2, 13)) +
         Bytes(14, Bytes(1, "names") + Bytes(2, "{0: 'red', 1: 'green', 2: 'blue'}"));
}

}  // namespace deepslam::testing_support
