// Pieces of a mesh: what faces with common vertices join.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "deepslam/core/disjoint_sets.h"

namespace deepslam {

// Of each vertex the piece, by its least vertex. A vertex that no face has is one by itself.
inline std::vector<std::uint32_t> PieceOfVertex(std::span<const std::array<std::uint32_t, 3>> faces,
                                                std::size_t num_vertices) {
  DisjointSets pieces(num_vertices);
  for (const auto& [a, b, c] : faces) {
    pieces.Join(a, b);
    pieces.Join(a, c);
  }
  return pieces.LeastOfEach();
}

}  // namespace deepslam
