// The bytes behind a glTF, as its buffers, buffer views and accessors divide them.
//
// No number of the file is trusted: what is given out lies within bytes that are there.
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "deepslam/gltf/json_place.h"

namespace deepslam::gltf {

// Bytes of a file that a glTF names, by its path relative to the glTF's folder, never one that
// leads out of it; nothing when there is none.
using ResourceLookup = std::function<std::optional<std::string>(const std::string& path)>;

struct GltfView {
  std::string_view bytes;
  std::uint64_t offset = 0;  // in its buffer
  std::uint64_t stride = 0;  // 0 = tightly packed
};

// Component types of glTF 2.0, 3.6.2.2.
enum GltfComponent : int {
  kByte = 5120,
  kUnsignedByte = 5121,
  kShort = 5122,
  kUnsignedShort = 5123,
  kUnsignedInt = 5125,
  kFloat = 5126,
};

// Elements of one kind.
struct GltfAccessor {
  std::string place;
  bool has_data = false;  // else something has to fill it: Draco
  std::uint64_t count = 0;
  int component_type = 0;
  int num_components = 0;
  bool is_matrix = false;
  bool normalised = false;  // integers stand for [0, 1] or [-1, 1]
  bool packed = true;       // its view has no stride

  // Of an accessor with data, below `count` and `num_components`.
  [[nodiscard]] float At(std::uint64_t element, int component) const;
  [[nodiscard]] std::uint32_t WholeAt(std::uint64_t element) const;  // of unsigned numbers

 private:
  friend class GltfBuffers;
  const char* data_ = nullptr;
  std::uint64_t stride_ = 0;
  int component_bytes_ = 0;
};

class GltfBuffers {
 public:
  // `binary` is what the GLB itself holds. Everything outlives this.
  GltfBuffers(const JsonPlace& root, std::string_view binary, const ResourceLookup& beside);

  [[nodiscard]] std::string_view binary() const { return binary_; }
  [[nodiscard]] std::size_t num_views() const { return num_views_; }
  [[nodiscard]] std::size_t num_accessors() const { return num_accessors_; }
  // Of the number that stands at `reference`. Nothing where none stands there; nothing, and an
  // error, where it is none of them or what it names is damaged.
  [[nodiscard]] std::optional<GltfView> View(const JsonPlace& reference);
  [[nodiscard]] std::optional<GltfAccessor> Accessor(const JsonPlace& reference);
  [[nodiscard]] std::optional<std::string_view> BufferAt(std::size_t number);
  [[nodiscard]] std::optional<GltfView> ViewAt(std::size_t number);
  [[nodiscard]] std::optional<GltfAccessor> AccessorAt(std::size_t number);
  // Bytes of an image file. Nothing where it is missing: textures are no reason to refuse a model.
  [[nodiscard]] std::optional<std::string> Image(const JsonPlace& image);

 private:
  static void ReadElementType(const JsonPlace& place, GltfAccessor& accessor);
  // Whether the view holds all elements.
  static bool Place(const GltfView& view,
                    std::uint64_t offset,
                    const JsonPlace& place,
                    GltfAccessor& accessor);
  std::optional<std::string_view> ReadBuffer(const JsonPlace& place);
  std::optional<std::string> Resource(const std::string& uri);
  bool Afford(std::uint64_t num_bytes);

  JsonPlace root_;
  std::string_view binary_;
  const ResourceLookup& beside_;
  std::size_t num_views_ = 0;
  std::size_t num_accessors_ = 0;
  std::deque<std::string> read_;  // what is not `binary_`; nothing in it moves
  std::map<std::size_t, std::optional<std::string_view>> buffers_;  // nothing: damaged
  std::uint64_t num_bytes_ = 0;
};

}  // namespace deepslam::gltf
