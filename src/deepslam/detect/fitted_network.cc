#include "deepslam/detect/fitted_network.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <initializer_list>
#include <limits>
#include <set>
#include <span>
#include <vector>

#include "deepslam/detect/grid_cells.h"
#include "onnx_excerpt.pb.h"

namespace deepslam::detect {
namespace {

namespace onnx = onnx_excerpt;

constexpr int kFloat = 1;  // of TensorProto.DataType
constexpr int kInt64 = 7;  // of TensorProto.DataType

bool LiesIn(Sides sides, const GridCell& cell) {
  return cell.u < sides.width / cell.stride && cell.v < sides.height / cell.stride;
}

// What networks note of their cells, a row each: centres, in cells or in pixels; strides.
using Note = float (*)(const GridCell&);
float U(const GridCell& cell) { return static_cast<float>(cell.u) + 0.5F; }
float V(const GridCell& cell) { return static_cast<float>(cell.v) + 0.5F; }
float Stride(const GridCell& cell) { return static_cast<float>(cell.stride); }
float UPx(const GridCell& cell) { return U(cell) * Stride(cell); }
float VPx(const GridCell& cell) { return V(cell) * Stride(cell); }

bool HasRows(std::span<const float> table,
             std::initializer_list<Note> notes,
             std::span<const GridCell> cells) {
  if (table.size() != notes.size() * cells.size()) return false;
  return std::ranges::all_of(notes, [&](Note note) {
    const std::span<const float> row = table.first(cells.size());
    table = table.subspan(cells.size());
    return std::ranges::equal(row, cells, {}, {}, note);
  });
}

bool IsKnown(std::span<const float> table, std::span<const GridCell> cells) {
  return HasRows(table, {U, V}, cells) || HasRows(table, {UPx, VPx}, cells) ||
         HasRows(table, {Stride}, cells);
}

// Nothing where there are not as many values as the tensor's dimensions say.
template <typename T, typename Listed>
std::optional<std::vector<T>> ValuesOf(const onnx::Tensor& tensor, const Listed& listed) {
  std::vector<T> values(listed.begin(), listed.end());
  if (tensor.has_raw_data()) {
    values.resize(tensor.raw_data().size() / sizeof(T));
    if (!values.empty())
      std::memcpy(values.data(), tensor.raw_data().data(), values.size() * sizeof(T));
  }
  std::uint64_t left = values.size();
  for (const std::int64_t side : tensor.dims()) {
    if (side <= 0 || left % static_cast<std::uint64_t>(side) != 0) return std::nullopt;
    left /= static_cast<std::uint64_t>(side);
  }
  if (left != 1) return std::nullopt;
  return values;
}

template <typename T>
void SetValues(const std::vector<T>& values, onnx::Tensor& tensor) {
  tensor.clear_float_data();
  tensor.clear_int64_data();
  tensor.set_raw_data(values.data(), values.size() * sizeof(T));
}

// A tensor's shape as it is with other sides of the input: images end with a grid's height and
// width, lists with its number of cells.
std::vector<std::int64_t> ShapeFor(std::vector<std::int64_t> shape, Sides from, Sides to) {
  if (shape.empty()) return shape;
  std::int64_t& last = shape.back();
  if (last == NumCells(from)) {
    last = NumCells(to);
    return shape;
  }
  for (const int stride : kStrides) {
    const bool image =
        shape.size() == 4 && shape[2] == from.height / stride && last == from.width / stride;
    if (image) {
      shape[2] = to.height / stride;
      last = to.width / stride;
      return shape;
    }
    if (last == NumCells(from, stride)) {
      last = NumCells(to, stride);
      return shape;
    }
  }
  return shape;
}

// Names of what says which shape a tensor is to have.
std::set<std::string> ShapeNames(const onnx::Graph& graph) {
  std::set<std::string> names;
  for (const onnx::Node& node : graph.node()) {
    if (node.op_type() == "Reshape" && node.input_size() > 1) names.insert(node.input(1));
    if (node.op_type() == "Resize" && node.input_size() > 3) names.insert(node.input(3));
  }
  return names;
}

// A network's constants, brought from the sides of one input to those of another, no larger one.
class Refit {
 public:
  Refit(Sides from, Sides to) : from_(from), to_(to), cells_(GridCells(from)) {}

  // False where something is noted of the cells that is not known here.
  [[nodiscard]] bool operator()(onnx::Graph& graph) const {
    const std::set<std::string> shapes = ShapeNames(graph);
    for (onnx::Tensor& tensor : *graph.mutable_initializer()) {
      if (!Constant(shapes.contains(tensor.name()), tensor)) return false;
    }
    for (onnx::Node& node : *graph.mutable_node()) {
      if (node.op_type() != "Constant" || node.output_size() != 1) continue;
      for (onnx::Attribute& attribute : *node.mutable_attribute()) {
        if (attribute.has_t() && !Constant(shapes.contains(node.output(0)), *attribute.mutable_t()))
          return false;
      }
    }
    return true;
  }

 private:
  [[nodiscard]] bool Constant(bool is_shape, onnx::Tensor& tensor) const {
    if (is_shape && tensor.data_type() == kInt64) return Shape(tensor);
    const bool of_cells = tensor.dims_size() > 0 && tensor.dims(tensor.dims_size() - 1) ==
                                                        static_cast<std::int64_t>(cells_.size());
    return !of_cells || (tensor.data_type() == kFloat && Table(tensor));
  }

  [[nodiscard]] bool Shape(onnx::Tensor& tensor) const {
    const auto shape = ValuesOf<std::int64_t>(tensor, tensor.int64_data());
    if (!shape) return false;
    SetValues(ShapeFor(*shape, from_, to_), tensor);
    return true;
  }

  [[nodiscard]] bool Table(onnx::Tensor& tensor) const {
    const auto table = ValuesOf<float>(tensor, tensor.float_data());
    if (!table || !IsKnown(*table, cells_)) return false;
    std::vector<float> kept;
    for (std::size_t n = 0; n < table->size(); ++n) {
      if (LiesIn(to_, cells_[n % cells_.size()])) kept.push_back((*table)[n]);
    }
    tensor.set_dims(tensor.dims_size() - 1, NumCells(to_));
    SetValues(kept, tensor);
    return true;
  }

  Sides from_;
  Sides to_;
  std::vector<GridCell> cells_;
};

onnx::Shape* InputShape(onnx::Graph& graph) {
  if (graph.input_size() != 1) return nullptr;
  onnx::Shape* shape =
      graph.mutable_input(0)->mutable_type()->mutable_tensor_type()->mutable_shape();
  return shape->dim_size() == 4 ? shape : nullptr;
}

// Nothing where one is left open or no detector's.
std::optional<Sides> SidesOf(const onnx::Shape& shape) {
  const std::int64_t height = shape.dim(2).dim_value();
  const std::int64_t width = shape.dim(3).dim_value();
  if (!CanBeInput(width, height)) return std::nullopt;
  return Sides{static_cast<int>(width), static_cast<int>(height)};
}

// What is stated of tensors on the way is found again by who loads it.
void ForgetStatedShapes(onnx::Graph& graph) {
  graph.clear_value_info();
  for (onnx::Value& output : *graph.mutable_output())
    output.mutable_type()->mutable_tensor_type()->clear_shape();
}

}  // namespace

std::optional<std::string> FittedNetwork(std::string_view onnx_bytes, Sides picture) {
  if (picture == Sides()) return std::nullopt;
  onnx::Model model;
  if (onnx_bytes.size() > std::numeric_limits<int>::max() ||
      !model.ParseFromArray(onnx_bytes.data(), static_cast<int>(onnx_bytes.size()))) {
    return std::nullopt;
  }
  onnx::Graph& graph = *model.mutable_graph();
  onnx::Shape* const shape = InputShape(graph);
  const std::optional<Sides> own = shape != nullptr ? SidesOf(*shape) : std::nullopt;
  if (!own) return std::nullopt;
  const Sides fitted = FitSides(picture, *own);
  if (fitted == *own || !Refit(*own, fitted)(graph)) return std::nullopt;
  shape->mutable_dim(2)->set_dim_value(fitted.height);
  shape->mutable_dim(3)->set_dim_value(fitted.width);
  ForgetStatedShapes(graph);
  return model.SerializeAsString();
}

}  // namespace deepslam::detect
