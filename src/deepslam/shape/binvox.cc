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

// Voxels in the order of the file: x slowest, then z, then y. The grid's own order is x, y, z.
using Slab = std::array<std::uint8_t, static_cast<std::size_t>(kGridSize) * kGridSize>;

// The voxels of one x, 0 or 1.
void TakeSlab(const VoxelGrid& grid, std::size_t i, Slab& slab) {
  constexpr std::size_t kSize = kGridSize;
  const std::uint8_t* const voxels = grid.occupied.data() + i * slab.size();
  for (std::size_t j = 0; j < kSize; ++j) {
    for (std::size_t k = 0; k < kSize; ++k)
      slab[k * kSize + j] = voxels[j * kSize + k] != 0 ? 1 : 0;
  }
}

// Sets the voxel at a place of the file and those behind it.
void SetRun(std::size_t place, std::size_t run, VoxelGrid& grid) {
  constexpr std::size_t kSize = kGridSize;
  for (const std::size_t end = place + run; place < end; ++place) {
    const std::size_t i = place / (kSize * kSize);
    const std::size_t k = place / kSize % kSize;
    const std::size_t j = place % kSize;
    grid.occupied[(i * kSize + j) * kSize + k] = 1;
  }
}

// The header's lines up to and with "data"; the rest stays in `bytes`.
Status SkipHeader(std::string_view& bytes) {
  constexpr int kMaxLines = 64;  // of a header; longer ones are refused
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
  constexpr std::size_t kMaxRun = 255;  // the length is a byte
  Slab slab;
  std::uint8_t value = 0;
  std::size_t run = 0;
  const auto end_run = [&] {
    if (run == 0) return;
    bytes.push_back(static_cast<char>(value));
    bytes.push_back(static_cast<char>(run));
    run = 0;
  };
  for (std::size_t i = 0; i < kGridSize; ++i) {
    TakeSlab(grid, i, slab);
    for (const std::uint8_t voxel : slab) {
      if (voxel != value || run == kMaxRun) end_run();
      value = voxel;
      ++run;
    }
  }
  end_run();
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
    if (value != 0) SetRun(place, run, grid);  // a new grid is empty
    place += run;
  }
  if (place != kCount) return InvalidInput("binvox: fewer voxels than 64^3, file cut off?");
  return grid;
}

}  // namespace deepslam::shape
