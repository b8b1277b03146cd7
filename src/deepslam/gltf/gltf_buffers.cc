#include "deepslam/gltf/gltf_buffers.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstring>
#include <limits>
#include <utility>

#include "deepslam/core/base64.h"
#include "deepslam/core/result.h"

namespace deepslam::gltf {
namespace {

// Of all buffers and textures together.
constexpr std::uint64_t kMaxBufferBytes = std::uint64_t{1} << 30;
constexpr std::size_t kMaxToldBytes = 80;  // of a URI

struct ElementType {
  std::string_view name;
  int num_components;
};
constexpr auto kElementTypes = std::to_array<ElementType>(
    {{"SCALAR", 1}, {"VEC2", 2}, {"VEC3", 3}, {"VEC4", 4}, {"MAT2", 4}, {"MAT3", 9}, {"MAT4", 16}});

// 0 for what is no component type.
int ComponentBytes(std::uint64_t component_type) {
  switch (component_type) {
    case kByte:
    case kUnsignedByte:
      return 1;
    case kShort:
    case kUnsignedShort:
      return 2;
    case kUnsignedInt:
    case kFloat:
      return 4;
    default:
      return 0;
  }
}

template <typename T>
T ReadAs(const char* at) {
  T value;
  std::memcpy(&value, at, sizeof value);
  return value;
}

template <typename T>
float Scaled(const char* at, bool normalised) {
  const auto value = static_cast<float>(ReadAs<T>(at));
  return normalised ? std::max(value / static_cast<float>(std::numeric_limits<T>::max()), -1.0F)
                    : value;
}

// %20 and its like.
std::string Unescaped(const std::string& uri) {
  std::string path;
  for (std::size_t n = 0; n < uri.size(); ++n) {
    const bool escaped = uri[n] == '%' && n + 2 < uri.size() &&
                         std::isxdigit(static_cast<unsigned char>(uri[n + 1])) != 0 &&
                         std::isxdigit(static_cast<unsigned char>(uri[n + 2])) != 0;
    path += escaped ? static_cast<char>(std::stoi(uri.substr(n + 1, 2), nullptr, 16)) : uri[n];
    if (escaped) n += 2;
  }
  return path;
}

bool LeadsAway(const std::string& path) {
  return path.starts_with('/') || path.find("..") != std::string::npos ||
         path.find(':') != std::string::npos || path.find('\\') != std::string::npos ||
         path.find('\0') != std::string::npos;
}

}  // namespace

float GltfAccessor::At(std::uint64_t element, int component) const {
  const char* at =
      data_ + element * stride_ + static_cast<std::uint64_t>(component * component_bytes_);
  switch (component_type) {
    case kByte:
      return Scaled<std::int8_t>(at, normalised);
    case kUnsignedByte:
      return Scaled<std::uint8_t>(at, normalised);
    case kShort:
      return Scaled<std::int16_t>(at, normalised);
    case kUnsignedShort:
      return Scaled<std::uint16_t>(at, normalised);
    case kUnsignedInt:
      return static_cast<float>(ReadAs<std::uint32_t>(at));
    default:
      return ReadAs<float>(at);
  }
}

std::uint32_t GltfAccessor::WholeAt(std::uint64_t element) const {
  const char* at = data_ + element * stride_;
  if (component_bytes_ == 1) return ReadAs<std::uint8_t>(at);
  return component_bytes_ == 2 ? ReadAs<std::uint16_t>(at) : ReadAs<std::uint32_t>(at);
}

GltfBuffers::GltfBuffers(const JsonPlace& root,
                         std::string_view binary,
                         const ResourceLookup& beside)
    : root_(root),
      binary_(binary),
      beside_(beside),
      num_views_(root["bufferViews"].Size()),
      num_accessors_(root["accessors"].Size()) {}

std::optional<GltfView> GltfBuffers::View(const JsonPlace& reference) {
  const int number = reference.Index(num_views_);
  return number < 0 ? std::nullopt : ViewAt(static_cast<std::size_t>(number));
}

std::optional<GltfAccessor> GltfBuffers::Accessor(const JsonPlace& reference) {
  const int number = reference.Index(num_accessors_);
  return number < 0 ? std::nullopt : AccessorAt(static_cast<std::size_t>(number));
}

std::optional<GltfView> GltfBuffers::ViewAt(std::size_t number) {
  const JsonPlace place = root_["bufferViews"].At(number);
  const JsonPlace reference = place["buffer"];
  const int buffer = reference.Index(root_["buffers"].Size());
  if (buffer < 0) {
    if (!reference.exists()) reference.Error("is missing");
    return std::nullopt;
  }
  const std::optional<std::string_view> bytes = BufferAt(static_cast<std::size_t>(buffer));
  if (!bytes) return std::nullopt;
  const std::uint64_t offset = place["byteOffset"].Whole(0);
  const std::uint64_t length = place["byteLength"].Whole(0);
  const std::uint64_t stride = place["byteStride"].Whole(0);
  if (length == 0) place.Breach("has no bytes");
  if (place["byteStride"].exists() && (stride < 4 || stride > 252 || stride % 4 != 0))
    place["byteStride"].Breach(std::to_string(stride) + " is not allowed");
  if (offset > bytes->size() || length > bytes->size() - offset) {
    place.Error("takes bytes " + std::to_string(offset) + " + " + std::to_string(length) + " of " +
                std::to_string(bytes->size()));
    return std::nullopt;
  }
  return GltfView{bytes->substr(offset, length), offset, stride};
}

std::optional<GltfAccessor> GltfBuffers::AccessorAt(std::size_t number) {
  const JsonPlace place = root_["accessors"].At(number);
  const std::size_t errors_before = place.num_errors();
  GltfAccessor accessor;
  accessor.place = place.name();
  accessor.count = place["count"].Whole(0);
  accessor.normalised = place["normalized"].IsTrue();
  ReadElementType(place, accessor);
  if (place["sparse"].exists())
    place["sparse"].Error("is not supported; export without sparse accessors");
  if (accessor.count == 0) place["count"].Breach("must be 1 or more");
  const std::uint64_t offset = place["byteOffset"].Whole(0);
  const std::optional<GltfView> view = View(place["bufferView"]);
  if (place.num_errors() != errors_before) return std::nullopt;
  if (view && !Place(*view, offset, place, accessor)) return std::nullopt;
  return accessor;
}

void GltfBuffers::ReadElementType(const JsonPlace& place, GltfAccessor& accessor) {
  const std::uint64_t component_type = place["componentType"].Whole(0);
  accessor.component_bytes_ = ComponentBytes(component_type);
  accessor.component_type = accessor.component_bytes_ > 0 ? static_cast<int>(component_type) : 0;
  const std::string type = place["type"].Text();
  const auto* const known = std::ranges::find(kElementTypes, type, &ElementType::name);
  accessor.num_components = known == kElementTypes.end() ? 0 : known->num_components;
  accessor.is_matrix = type.starts_with("MAT");
  if (accessor.component_bytes_ == 0) place["componentType"].Error("is unknown");
  if (accessor.num_components == 0) place["type"].Error("is unknown");
}

bool GltfBuffers::Place(const GltfView& view,
                        std::uint64_t offset,
                        const JsonPlace& place,
                        GltfAccessor& accessor) {
  const auto component = static_cast<std::uint64_t>(accessor.component_bytes_);
  const std::uint64_t element = component * static_cast<std::uint64_t>(accessor.num_components);
  const std::uint64_t stride = view.stride == 0 ? element : view.stride;
  const std::uint64_t size = view.bytes.size();
  if (offset % component != 0 || (view.offset + offset) % component != 0)
    place["byteOffset"].Breach("is not aligned to its component");
  if (stride % component != 0)
    place.Breach("has a stride of " + std::to_string(stride) + ", no multiple of its component");
  // Without overflow: every factor is bounded by the view before it is multiplied.
  const bool fits =
      accessor.count == 0 || (stride >= element && offset <= size && element <= size - offset &&
                              accessor.count - 1 <= (size - offset - element) / stride);
  if (!fits) {
    place["count"].Error("says " + std::to_string(accessor.count) +
                         " elements, more than its buffer view holds");
    return false;
  }
  accessor.has_data = true;
  accessor.packed = view.stride == 0;
  accessor.stride_ = stride;
  if (accessor.count > 0) accessor.data_ = view.bytes.data() + offset;
  return true;
}

std::optional<std::string> GltfBuffers::Image(const JsonPlace& image) {
  if (image["bufferView"].exists()) {
    const std::optional<GltfView> view = View(image["bufferView"]);
    return view ? std::optional<std::string>(std::string(view->bytes)) : std::nullopt;
  }
  const std::string uri = image["uri"].Text();
  return uri.empty() ? std::nullopt : Resource(uri);
}

std::optional<std::string> GltfBuffers::Resource(const std::string& uri) {
  if (uri.starts_with("data:")) {
    const std::size_t comma = uri.find(";base64,");
    if (comma == std::string::npos) return std::nullopt;
    Result<std::string> bytes = DecodeBase64(std::string_view(uri).substr(comma + 8));
    if (!bytes || !Afford(bytes->size())) return std::nullopt;
    return *std::move(bytes);
  }
  const std::string path = Unescaped(uri);
  if (LeadsAway(path)) return std::nullopt;
  std::optional<std::string> bytes = beside_(path);
  if (bytes && !Afford(bytes->size())) return std::nullopt;
  return bytes;
}

bool GltfBuffers::Afford(std::uint64_t num_bytes) {
  num_bytes_ += num_bytes;
  if (num_bytes_ > kMaxBufferBytes)
    root_["buffers"].Error("hold more than 1 GiB, textures included");
  return num_bytes_ <= kMaxBufferBytes;
}

std::optional<std::string_view> GltfBuffers::BufferAt(std::size_t number) {
  const auto [known, is_new] = buffers_.try_emplace(number);
  if (is_new) known->second = ReadBuffer(root_["buffers"].At(number));
  return known->second;
}

std::optional<std::string_view> GltfBuffers::ReadBuffer(const JsonPlace& place) {
  const std::uint64_t length = place["byteLength"].Whole(0);
  const std::string uri = place["uri"].Text();
  std::string_view bytes = binary_;
  if (!uri.empty()) {
    std::optional<std::string> read = Resource(uri);
    if (!read) {
      place["uri"].Error(std::string("'") + uri.substr(0, kMaxToldBytes) +
                         "' cannot be read; put that file beside the model, or export as .glb");
      return std::nullopt;
    }
    bytes = read_.emplace_back(*std::move(read));
  }
  if (length == 0) place["byteLength"].Breach("must be 1 or more");
  if (bytes.size() < length) {
    place["byteLength"].Error("says " + std::to_string(length) + " bytes, there are " +
                              std::to_string(bytes.size()) + ": is the file cut off?");
    return std::nullopt;
  }
  return bytes.substr(0, length);
}

}  // namespace deepslam::gltf
