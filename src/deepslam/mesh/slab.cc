#include "deepslam/mesh/slab.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <map>
#include <tuple>
#include <utility>

#include <Eigen/Geometry>

#include "deepslam/mesh/colour_raster.h"
#include "deepslam/mesh/ground_polygon.h"

namespace deepslam::mesh {
namespace {

constexpr double kSameBreak_m = 1e-4;  // breaks nearer than this are one
constexpr int kMostSlabSteps = 400;    // along a side: walls of a hall, a vertex every decimetre
// Of the cells; of less, a mean colour says nothing of the wall.
constexpr double kColouredShare = 0.1;
// Of a face's raster of colours; bounds memory on huge walls.
constexpr std::size_t kMostCells = 40'000;

// Where the grid of a face is cut: at its ends, at its holes, and so often that no cell is wider
// than a step.
std::vector<double> BreaksOf(double low, double high, std::vector<double> cuts, double step_m) {
  cuts.push_back(low);
  cuts.push_back(high);
  std::sort(cuts.begin(), cuts.end());
  std::vector<double> coarse;
  for (const double cut : cuts) {
    if (cut < low || cut > high) continue;
    if (coarse.empty() || cut - coarse.back() > kSameBreak_m) coarse.push_back(cut);
  }
  const double step = std::max(step_m, (high - low) / kMostSlabSteps);
  std::vector<double> breaks;
  for (std::size_t n = 0; n + 1 < coarse.size(); ++n) {
    const double width = coarse[n + 1] - coarse[n];
    const int parts = std::max(1, static_cast<int>(std::ceil(width / step - 1e-9)));
    for (int part = 0; part < parts; ++part) breaks.push_back(coarse[n] + width * part / parts);
  }
  breaks.push_back(coarse.back());
  return breaks;
}

// Which cells of the face's grid are there.
class SlabGrid {
 public:
  explicit SlabGrid(const Slab& slab) {
    std::vector<double> x_cuts;
    std::vector<double> z_cuts;
    for (const SlabHole& hole : slab.holes) {
      x_cuts.insert(x_cuts.end(), {hole.left_m, hole.right_m});
      z_cuts.insert(z_cuts.end(), {hole.bottom_m, hole.top_m});
    }
    xs = BreaksOf(slab.left_m, slab.right_m, std::move(x_cuts), slab.step_m);
    zs = BreaksOf(slab.bottom_m, slab.top_m, std::move(z_cuts), slab.step_m);
    for (std::size_t i = 0; i + 1 < xs.size(); ++i) {
      for (std::size_t k = 0; k + 1 < zs.size(); ++k) {
        const double x = 0.5 * (xs[i] + xs[i + 1]);
        const double z = 0.5 * (zs[k] + zs[k + 1]);
        solid_.push_back(std::none_of(slab.holes.begin(), slab.holes.end(), [&](const auto& hole) {
          return x > hole.left_m && x < hole.right_m && z > hole.bottom_m && z < hole.top_m;
        }));
      }
    }
    while (FillOneMeetingOfCorners()) {
    }
  }

  [[nodiscard]] bool At(std::size_t i, std::size_t k) const {
    return solid_[i * (zs.size() - 1) + k];
  }

  std::vector<double> xs;
  std::vector<double> zs;

 private:
  // Cells that touch in a corner alone would share a vertex and no edge there.
  bool FillOneMeetingOfCorners() {
    for (std::size_t i = 0; i + 2 < xs.size(); ++i) {
      for (std::size_t k = 0; k + 2 < zs.size(); ++k) {
        const bool a = At(i, k);
        const bool b = At(i + 1, k);
        if (a == b || At(i + 1, k + 1) != a || At(i, k + 1) != b) continue;
        solid_[(a ? i + 1 : i) * (zs.size() - 1) + k] = true;
        return true;
      }
    }
    return false;
  }

  std::vector<bool> solid_;
};

// Face, back and, along edges that one cell has, the sides between them.
class SlabMesh {
 public:
  SlabMesh(const SlabGrid& grid, double thickness_m) : grid_(grid), thickness_m_(thickness_m) {}

  [[nodiscard]] TriangleMesh Make() && {
    for (std::size_t i = 0; i + 1 < grid_.xs.size(); ++i) {
      for (std::size_t k = 0; k + 1 < grid_.zs.size(); ++k) {
        if (grid_.At(i, k)) AddCell(i, k);
      }
    }
    return std::move(mesh_);
  }

 private:
  std::uint32_t Vertex(std::size_t i, std::size_t k, bool front) {
    const auto [place, is_new] =
        known_.try_emplace({i, k, front}, static_cast<std::uint32_t>(mesh_.vertices.size()));
    if (is_new) {
      mesh_.vertices.emplace_back(static_cast<float>(grid_.xs[i]),
                                  front ? 0.0F : -static_cast<float>(thickness_m_),
                                  static_cast<float>(grid_.zs[k]));
    }
    return place->second;
  }
  void AddSquare(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
    mesh_.faces.push_back({a, b, c});
    mesh_.faces.push_back({a, c, d});
  }
  // A corner of the grid as the cells around it count from it.
  void AddSide(std::size_t i0, std::size_t k0, std::size_t i1, std::size_t k1) {
    AddSquare(
        Vertex(i1, k1, true), Vertex(i0, k0, true), Vertex(i0, k0, false), Vertex(i1, k1, false));
  }
  [[nodiscard]] bool IsThere(std::size_t i, std::size_t k) const {
    return i + 1 < grid_.xs.size() && k + 1 < grid_.zs.size() && grid_.At(i, k);
  }
  void AddCell(std::size_t i, std::size_t k) {
    AddSquare(Vertex(i, k, true),
              Vertex(i, k + 1, true),
              Vertex(i + 1, k + 1, true),
              Vertex(i + 1, k, true));
    AddSquare(Vertex(i, k, false),
              Vertex(i + 1, k, false),
              Vertex(i + 1, k + 1, false),
              Vertex(i, k + 1, false));
    if (i == 0 || !IsThere(i - 1, k)) AddSide(i, k, i, k + 1);
    if (!IsThere(i, k + 1)) AddSide(i, k + 1, i + 1, k + 1);
    if (!IsThere(i + 1, k)) AddSide(i + 1, k + 1, i + 1, k);
    if (k == 0 || !IsThere(i, k - 1)) AddSide(i + 1, k, i, k);
  }

  const SlabGrid& grid_;
  double thickness_m_;
  TriangleMesh mesh_;
  std::map<std::tuple<std::size_t, std::size_t, bool>, std::uint32_t> known_;
};

Rgb8 MeanOf(const Image<Rgb8>& image) {
  double sum[3] = {0, 0, 0};
  for (const Rgb8& colour : image) {
    sum[0] += colour.r;
    sum[1] += colour.g;
    sum[2] += colour.b;
  }
  const auto mean = [&](int channel) {
    return static_cast<std::uint8_t>(
        std::lround(sum[channel] / (static_cast<double>(image.width()) * image.height())));
  };
  return {mean(0), mean(1), mean(2)};
}

}  // namespace

TriangleMesh MakeSlab(const Slab& slab) {
  const auto positive = [](double size) { return std::isfinite(size) && size > kSameBreak_m; };
  if (!positive(slab.right_m - slab.left_m) || !positive(slab.top_m - slab.bottom_m) ||
      !positive(slab.thickness_m) || !positive(slab.step_m))
    return {};
  const SlabGrid grid(slab);
  return SlabMesh(grid, slab.thickness_m).Make();
}

void ColourSlab(const TriangleMesh& surface_world,
                const Pose3& world_from_slab,
                const SlabColours& options,
                TriangleMesh& mesh) {
  if (mesh.empty() || surface_world.colours.empty()) return;
  Eigen::AlignedBox2d box;
  for (const Eigen::Vector3f& p : mesh.vertices)
    box.extend(Eigen::Vector2d(static_cast<double>(p.x()), static_cast<double>(p.z())));
  ColourRaster raster(box, options.step_m, kMostCells);
  const Pose3 slab_from_world = world_from_slab.Inverse();
  std::map<std::pair<int, int>, int> seen;
  for (std::size_t v = 0; v < surface_world.vertices.size(); ++v) {
    const Eigen::Vector3d p = slab_from_world * surface_world.vertices[v].cast<double>();
    const Eigen::Vector2d at(p.x(), p.z());
    if (std::abs(p.y()) > options.reach_m || !box.contains(at)) continue;
    raster.Add(at, surface_world.colours[v]);
    const Eigen::Vector2i cell = raster.CellOf(at);
    ++seen[{cell.x(), cell.y()}];
  }
  if (raster.empty()) return;
  const Image<Rgb8> colours = raster.Filled();
  const double num_cells = static_cast<double>(colours.width()) * colours.height();
  if (static_cast<double>(seen.size()) < kColouredShare * num_cells) return;
  const Rgb8 mean = MeanOf(colours);
  mesh.colours.clear();
  for (const Eigen::Vector3f& p : mesh.vertices) {
    const Eigen::Vector2i cell =
        raster.CellOf({static_cast<double>(p.x()), static_cast<double>(p.z())});
    mesh.colours.push_back(p.y() < 0 ? mean : colours(cell.x(), cell.y()));
  }
}

Result<TriangleMesh> MakePrism(std::span<const Eigen::Vector2d> outline_m, double height_m) {
  Result<TriangleMesh> bottom = TriangulateOutline(outline_m);
  if (!bottom.ok()) return bottom.error();
  const auto size = static_cast<std::uint32_t>(bottom->vertices.size());
  TriangleMesh prism;
  prism.vertices = bottom->vertices;
  for (Eigen::Vector3f p : bottom->vertices) {
    p.z() = static_cast<float>(height_m);
    prism.vertices.push_back(p);
  }
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
  for (const auto& face : bottom->faces) {
    prism.faces.push_back({face[0], face[2], face[1]});
    prism.faces.push_back({face[0] + size, face[1] + size, face[2] + size});
    for (std::size_t n = 0; n < 3; ++n) ++edges[{face[n], face[(n + 1) % 3]}];
  }
  for (const auto& [edge, count] : edges) {
    const auto [a, b] = edge;
    if (edges.count({b, a}) != 0) continue;
    prism.faces.push_back({a, b, b + size});
    prism.faces.push_back({a, b + size, a + size});
  }
  return prism;
}

}  // namespace deepslam::mesh
