#include "deepslam/shape/binvox.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

namespace deepslam::shape {
namespace {

constexpr std::string_view kHeader =
    "#binvox 1\ndim 64 64 64\ntranslate -0.5 -0.5 -0.5\nscale 1\ndata\n";
constexpr std::size_t kCount = static_cast<std::size_t>(kGridSize) * kGridSize * kGridSize;

// Voxel of the grid at a place of the file: x slowest, then z, then y.
std::size_t GridIndex(std::size_t place) {
  constexpr std::size_t kSize = kGridSize;
  const std::size_t i = place / (kSize * kSize);
  const std::size_t k = place / kSize % kSize;
  const std::size_t j = place % kSize;
  return (i * kSize + j) * kSize + k;
}

// The header's lines up to and with "data"; the rest stays in `bytes`.
Status SkipHeader(std::string_view& bytes) {
  constexpr int kMaxLines = 64;
  bool magic = false;
  bool dim = false;
  for (int n = 0; n < kMaxLines; ++n) {
    const std::size_t end = bytes.substr(0, 256).find('\n');
    if (end == std::string_view::npos) break;
    std::string_view line = bytes.substr(0, end);
    bytes.remove_prefix(end + 1);
    if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
    if (n == 0 && line != "#binvox 1") break;
    magic = true;
    if (line.starts_with("dim ")) {
      if (line != "dim 64 64 64") {
        return InvalidInput("binvox: '" + std::string(line) + "', only 'dim 64 64 64' is a model");
      }
      dim = true;
    }
    if (line == "data") {
      if (dim) return Ok();
      return InvalidInput("binvox: header without 'dim 64 64 64'");
    }
  }
  return InvalidInput(magic ? "binvox: header without a 'data' line"
                            : "binvox: does not begin with '#binvox 1'");
}

}  // namespace

std::string WriteBinvox(const VoxelGrid& grid) {
  std::string bytes(kHeader);
  constexpr std::size_t kMaxRun = 255;
  for (std::size_t place = 0; place < kCount;) {
    const std::uint8_t value = grid.occupied[GridIndex(place)] != 0 ? 1 : 0;
    std::size_t run = 1;
    while (run < kMaxRun && place + run < kCount &&
           (grid.occupied[GridIndex(place + run)] != 0 ? 1 : 0) == value) {
      ++run;
    }
    bytes.push_back(static_cast<char>(value));
    bytes.push_back(static_cast<char>(run));
    place += run;
  }
  return bytes;
}

Result<VoxelGrid> ReadBinvox(std::string_view bytes) {
  if (const Status header = SkipHeader(bytes); !header) return header.error();
  if (bytes.size() % 2 != 0) return InvalidInput("binvox: data ends within a pair of bytes");
  VoxelGrid grid;
  std::size_t place = 0;
  for (std::size_t n = 0; n < bytes.size(); n += 2) {
    const auto value = static_cast<std::uint8_t>(bytes[n]);
    const auto run = static_cast<std::uint8_t>(bytes[n + 1]);
    if (value > 1 || run == 0) return InvalidInput("binvox: impossible run in the data");
    if (run > kCount - place) return InvalidInput("binvox: more voxels than 64^3");
    for (std::size_t end = place + run; place < end; ++place) {
      grid.occupied[GridIndex(place)] = value;
    }
  }
  if (place != kCount) return InvalidInput("binvox: fewer voxels than 64^3, file cut off?");
  return grid;
}

}  // namespace deepslam::shape
