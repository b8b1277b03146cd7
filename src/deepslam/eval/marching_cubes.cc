#include "deepslam/eval/marching_cubes.h"

#include <array>
#include <cstdint>
#include <map>
#include <utility>

namespace deepslam::eval {
namespace {

// Corner n of a cell lies at ((n >> 2) & 1, (n >> 1) & 1, n & 1).
constexpr int kNumCorners = 8;
using Face = std::array<int, 4>;
// Corners of each side, counter-clockwise seen from outside the cell.
constexpr std::array<Face, 6> kSides = {
    {{0, 1, 3, 2}, {4, 6, 7, 5}, {0, 4, 5, 1}, {2, 3, 7, 6}, {0, 2, 6, 4}, {1, 5, 7, 3}}};

struct Cell {
  std::array<float, kNumCorners> values;
  std::array<std::size_t, kNumCorners> samples;
};

// A crossed edge by the two samples at its ends, lower first.
using Edge = std::pair<std::size_t, std::size_t>;

Edge EdgeOf(const Cell& cell, int a, int b) {
  return std::minmax(
      {cell.samples[static_cast<std::size_t>(a)], cell.samples[static_cast<std::size_t>(b)]});
}

// Whether the two inside corners of a side with diagonal corners inside are joined across it.
bool JoinedInside(const std::array<float, 4>& v, float level) {
  const double cross = static_cast<double>(v[0]) * v[2] - static_cast<double>(v[1]) * v[3];
  const double sum = static_cast<double>(v[0]) + v[2] - v[1] - v[3];
  return sum != 0 && cross / sum > static_cast<double>(level);
}

// Links every edge where a walk round the side leaves the inside to the edge where it comes back
// in, so that the links of all sides form closed loops round the cell.
void LinkSide(const Cell& cell, const Face& side, float level, std::map<Edge, Edge>& next) {
  std::array<float, 4> values{};
  for (std::size_t n = 0; n < 4; ++n) values[n] = cell.values[static_cast<std::size_t>(side[n])];
  const auto inside = [&](std::size_t n) { return values[n % 4] > level; };
  const auto edge = [&](std::size_t n) { return EdgeOf(cell, side[n % 4], side[(n + 1) % 4]); };
  int crossings = 0;
  for (std::size_t n = 0; n < 4; ++n) crossings += inside(n) != inside(n + 1) ? 1 : 0;
  const bool joined = crossings == 4 && JoinedInside(values, level);
  for (std::size_t n = 0; n < 4; ++n) {
    if (!inside(n) || inside(n + 1)) continue;
    std::size_t back = n + 1;
    while (!(!inside(back) && inside(back + 1))) ++back;
    if (crossings == 4 && !joined) back = n + 3;
    next[edge(n)] = edge(back);
  }
}

class Builder {
 public:
  Builder(const Volume& volume, float level) : volume_(volume), level_(level) {}

  void AddCell(const Cell& cell) {
    next_.clear();
    for (const Face& side : kSides) LinkSide(cell, side, level_, next_);
    while (!next_.empty()) {
      std::vector<std::uint32_t> loop;
      for (auto at = next_.begin(); at != next_.end(); at = next_.find(to_)) {
        loop.push_back(VertexOn(at->first));
        to_ = at->second;
        next_.erase(at);
      }
      for (std::size_t n = 2; n < loop.size(); ++n)
        mesh_.faces.push_back({loop[0], loop[n], loop[n - 1]});
    }
  }
  [[nodiscard]] TriangleMesh Finish() { return std::move(mesh_); }

 private:
  [[nodiscard]] Eigen::Vector3d PointOf(std::size_t sample) const {
    const auto ny = static_cast<std::size_t>(volume_.size[1]);
    const auto nz = static_cast<std::size_t>(volume_.size[2]);
    return {static_cast<double>(sample / (ny * nz)),
            static_cast<double>(sample / nz % ny),
            static_cast<double>(sample % nz)};
  }
  std::uint32_t VertexOn(const Edge& edge) {
    const auto [found, is_new] =
        vertices_.try_emplace(edge, static_cast<std::uint32_t>(mesh_.vertices.size()));
    if (is_new) {
      const double a = volume_.values[edge.first];
      const double b = volume_.values[edge.second];
      const double t = (static_cast<double>(level_) - a) / (b - a);
      const Eigen::Vector3d from = PointOf(edge.first);
      mesh_.vertices.emplace_back((from + t * (PointOf(edge.second) - from)).cast<float>());
    }
    return found->second;
  }

  const Volume& volume_;
  float level_;
  std::map<Edge, Edge> next_;
  Edge to_;
  std::map<Edge, std::uint32_t> vertices_;
  TriangleMesh mesh_;
};

}  // namespace

TriangleMesh MarchingCubes(const Volume& volume, float level) {
  Builder builder(volume, level);
  for (int i = 0; i + 1 < volume.size[0]; ++i) {
    for (int j = 0; j + 1 < volume.size[1]; ++j) {
      for (int k = 0; k + 1 < volume.size[2]; ++k) {
        Cell cell{};
        int num_inside = 0;
        for (int n = 0; n < kNumCorners; ++n) {
          const std::size_t sample =
              volume.Index(i + ((n >> 2) & 1), j + ((n >> 1) & 1), k + (n & 1));
          cell.samples[static_cast<std::size_t>(n)] = sample;
          cell.values[static_cast<std::size_t>(n)] = volume.values[sample];
          num_inside += volume.values[sample] > level ? 1 : 0;
        }
        if (num_inside > 0 && num_inside < kNumCorners) builder.AddCell(cell);
      }
    }
  }
  return builder.Finish();
}

}  // namespace deepslam::eval
