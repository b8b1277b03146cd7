#include "deepslam/tracking/dynamic_mask.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "deepslam/alignment/reference_pixels.h"

namespace deepslam::tracking {
namespace {

// Of a pixel and its eight neighbours, so many have moved with it: outlines are off by a pixel.
constexpr int kMinTogether = 7;
// Between neighbouring pixels of one thing.
constexpr float kOneSurfaceM = 0.1F;
// What is hidden is hidden with its outlines, this many pixels around.
constexpr int kOutline = 2;
// Share of the frame's depth that is worth a change.
constexpr double kMinShareMoved = 0.02;

int CountAround(const Mask& mask, int u, int v, int radius) {
  int count = 0;
  for (int y = std::max(0, v - radius); y <= std::min(mask.height() - 1, v + radius); ++y) {
    for (int x = std::max(0, u - radius); x <= std::min(mask.width() - 1, u + radius); ++x)
      count += mask(x, y);
  }
  return count;
}

// Pixels with at least `least` set ones within `radius`.
Mask Where(const Mask& mask, int radius, int least, bool of_set_only) {
  Mask result(mask.width(), mask.height());
  for (int v = 0; v < mask.height(); ++v) {
    for (int u = 0; u < mask.width(); ++u) {
      const bool asked = mask(u, v) != 0 || !of_set_only;
      result(u, v) = asked && CountAround(mask, u, v, radius) >= least ? 1 : 0;
    }
  }
  return result;
}

// What nobody observed moves with what it hangs together with: a sleeve that no earlier frame had
// in view.
Mask WithWhatHangsOn(Mask moved, const Mask& observed, const PyramidLevel& level) {
  std::vector<std::pair<int, int>> front;
  for (int v = 0; v < moved.height(); ++v) {
    for (int u = 0; u < moved.width(); ++u) {
      if (moved(u, v) != 0) front.emplace_back(u, v);
    }
  }
  const auto depth_m = [&](int u, int v) {
    return level.depth_m[static_cast<std::size_t>(v * level.camera.width + u)];
  };
  while (!front.empty()) {
    const auto [u, v] = front.back();
    front.pop_back();
    for (const auto& [x, y] : {std::pair(u - 1, v), {u + 1, v}, {u, v - 1}, {u, v + 1}}) {
      if (x < 0 || y < 0 || x >= moved.width() || y >= moved.height()) continue;
      if (moved(x, y) != 0 || observed(x, y) != 0 || !(depth_m(x, y) > 0)) continue;
      if (std::abs(depth_m(x, y) - depth_m(u, v)) > kOneSurfaceM) continue;
      moved(x, y) = 1;
      front.emplace_back(x, y);
    }
  }
  return moved;
}

void Hide(const Mask& mask, PyramidLevel& level) {
  for (int v = 0; v < level.camera.height; ++v) {
    const int mask_v = std::min(mask.height() - 1, v * mask.height() / level.camera.height);
    for (int u = 0; u < level.camera.width; ++u) {
      const int mask_u = std::min(mask.width() - 1, u * mask.width() / level.camera.width);
      if (mask(mask_u, mask_v) == 0) continue;
      alignment::HidePixel(static_cast<std::size_t>(v * level.camera.width + u), level);
    }
  }
}

}  // namespace

Mask DynamicMask(const PlacedPyramid& frame,
                 std::span<const PlacedPyramid> earlier,
                 const DepthNoise& noise) {
  const FreeSpaceMasks masks = ObserveFreeSpace(frame, earlier, noise);
  return WithWhatHangsOn(Where(masks.violating, 1, kMinTogether, true),
                         masks.observed,
                         FreeSpaceLevel(*frame.pyramid));
}

std::shared_ptr<const FramePyramid> WithoutDynamic(const PlacedPyramid& frame,
                                                   std::span<const PlacedPyramid> earlier,
                                                   const DepthNoise& noise) {
  const Mask moved = DynamicMask(frame, earlier, noise);
  const UnfilledVector<float>& depth_m = FreeSpaceLevel(*frame.pyramid).depth_m;
  const auto num_valid = std::ranges::count_if(depth_m, [](float z) { return z > 0; });
  const auto num_moved = std::ranges::count(moved, std::uint8_t{1});
  if (static_cast<double>(num_moved) <= kMinShareMoved * static_cast<double>(num_valid))
    return frame.pyramid;
  auto hidden = std::make_shared<FramePyramid>(*frame.pyramid);
  const Mask outlined = Where(moved, kOutline, 1, false);
  for (PyramidLevel& level : hidden->levels) Hide(outlined, level);
  return hidden;
}

}  // namespace deepslam::tracking
