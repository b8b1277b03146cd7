// What the pictures of a report are drawn of, and small things that all of them need.
#pragma once

#include <algorithm>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "deepslam/core/image.h"
#include "deepslam/core/result.h"
#include "deepslam/report/report_content.h"
#include "deepslam/scene/object_map.h"
#include "deepslam/scene/triangle_mesh.h"

namespace deepslam::presentation {

// An object as the pictures need it; both outlive it.
struct PicturedObject {
  const MapObject* object = nullptr;
  const TriangleMesh* mesh = nullptr;  // metric object frame; empty: the object is in no picture
  Rgb8 colour;
};

// A picture that could not be encoded is left out.
inline void AddPicture(std::vector<report::Picture>& pictures,
                       Result<std::string> jpeg,
                       std::string caption) {
  if (jpeg.ok()) pictures.push_back({std::move(jpeg).value(), "image/jpeg", std::move(caption)});
}

// At most `max_count` of them, evenly.
template <typename T>
[[nodiscard]] std::vector<T> Spread(const std::vector<T>& all, int max_count) {
  std::vector<T> some;
  const std::size_t count = std::min(all.size(), static_cast<std::size_t>(max_count));
  for (std::size_t n = 0; n < count; ++n)
    some.push_back(all[(2 * n + 1) * all.size() / (2 * count)]);
  return some;
}

}  // namespace deepslam::presentation
