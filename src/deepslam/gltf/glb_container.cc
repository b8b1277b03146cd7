#include "deepslam/gltf/glb_container.h"

#include <cstddef>
#include <cstdint>
#include <string>

namespace deepslam::gltf {
namespace {

constexpr std::uint32_t kMagic = 0x46546C67;        // "glTF"
constexpr std::uint32_t kJsonChunk = 0x4E4F534A;    // "JSON"
constexpr std::uint32_t kBinaryChunk = 0x004E4942;  // "BIN" and a zero

std::uint32_t U32At(std::string_view bytes, std::size_t at) {
  std::uint32_t value = 0;
  for (std::size_t n = 0; n < 4; ++n) {
    value |= static_cast<std::uint32_t>(static_cast<unsigned char>(bytes[at + n])) << (8 * n);
  }
  return value;
}

}  // namespace

std::optional<GlbChunks> ReadGlbChunks(std::string_view bytes, Findings& findings) {
  if (bytes.size() < 20 || U32At(bytes, 0) != kMagic) {
    findings.Error("header",
                   "not a GLB: " + std::to_string(bytes.size()) +
                       " bytes that do not begin with a glTF header");
    return std::nullopt;
  }
  if (U32At(bytes, 4) != 2) {
    findings.Error("header", "version " + std::to_string(U32At(bytes, 4)) + " instead of 2");
    return std::nullopt;
  }
  if (U32At(bytes, 8) != bytes.size()) {
    findings.Error("header",
                   "length " + std::to_string(U32At(bytes, 8)) + " but the file has " +
                       std::to_string(bytes.size()) + " bytes: truncated or damaged");
    return std::nullopt;
  }
  GlbChunks chunks;
  for (std::size_t at = 12, n = 0; at < bytes.size(); ++n) {
    const std::string place = "chunk " + std::to_string(n);
    if (bytes.size() - at < 8) {
      findings.Error(place, "header is cut off");
      return std::nullopt;
    }
    const std::size_t length = U32At(bytes, at);
    const std::uint32_t type = U32At(bytes, at + 4);
    if (length % 4 != 0 || length > bytes.size() - at - 8) {
      findings.Error(place,
                     "length " + std::to_string(length) +
                         " is no multiple of 4 or goes past the end of the file");
      return std::nullopt;
    }
    const std::string_view content = bytes.substr(at + 8, length);
    if ((n == 0) != (type == kJsonChunk)) {
      findings.Error(place, "the first chunk, and no other, must be JSON");
      return std::nullopt;
    }
    if (n == 0) chunks.json = content;
    if (type == kBinaryChunk && n != 1) findings.Error(place, "BIN must be the second chunk");
    if (type == kBinaryChunk && n == 1) chunks.binary = content;
    if (type != kBinaryChunk && n > 0) findings.Warn(place, "unknown type, ignored");
    at += 8 + length;
  }
  return chunks;
}

}  // namespace deepslam::gltf
