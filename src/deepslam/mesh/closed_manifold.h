// A cheap test of faces that most meshes pass, so that a dear one need not be asked.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

namespace deepslam::mesh {

// Whether faces of N different corners each make an oriented surface without rim: about every
// vertex that they use lies one closed fan of faces. Indices below `num_vertices`.
template <typename Index, std::size_t N>
[[nodiscard]] bool IsClosedManifold(const std::vector<std::array<Index, N>>& faces,
                                    std::size_t num_vertices) {
  struct Corner {
    Index before = 0;  // along the face
    Index after = 0;
  };
  std::vector<std::size_t> begin(num_vertices + 1, 0);
  for (const auto& face : faces) {
    for (const Index v : face) ++begin[static_cast<std::size_t>(v) + 1];
  }
  for (std::size_t v = 0; v < num_vertices; ++v) begin[v + 1] += begin[v];
  std::vector<std::size_t> next(begin.begin(), begin.end() - 1);
  std::vector<Corner> corners(begin.back());
  for (const auto& face : faces) {
    for (std::size_t n = 0; n < N; ++n) {
      if (std::find(face.begin() + static_cast<std::ptrdiff_t>(n) + 1, face.end(), face[n]) !=
          face.end()) {
        return false;
      }
      corners[next[static_cast<std::size_t>(face[n])]++] = {face[(n + N - 1) % N],
                                                            face[(n + 1) % N]};
    }
  }
  for (std::size_t v = 0; v < num_vertices; ++v) {
    const auto first = corners.begin() + static_cast<std::ptrdiff_t>(begin[v]);
    const auto last = corners.begin() + static_cast<std::ptrdiff_t>(begin[v + 1]);
    // The fan is put in order: each face beside the one that it shares an edge with.
    for (auto corner = first; corner != last; ++corner) {
      const Index rim = corner == first ? first->after : (corner - 1)->before;
      const auto beside =
          std::find_if(corner, last, [&](const Corner& other) { return other.after == rim; });
      if (beside == last) return false;
      std::iter_swap(corner, beside);
      if (std::any_of(corner + 1, last, [&](const Corner& other) { return other.after == rim; }))
        return false;
    }
    if (first != last && (last - 1)->before != first->after) return false;
  }
  return true;
}

}  // namespace deepslam::mesh
