#include "deepslam/mesh/colour_raster.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include "deepslam/core/check.h"

namespace deepslam::mesh {
namespace {

// A cell's colour times its weight, and the weight, at most 1: how much of it was seen.
using Weighted = Eigen::Vector4d;

// No cell counts for more than one that was seen as a whole, or near ones would drown in far ones.
Weighted Saturated(const Weighted& cell) { return cell / std::max(1.0, cell.w()); }

// Half as many cells each way, each what its four say together.
Image<Weighted> Pulled(const Image<Weighted>& fine) {
  Image<Weighted> coarse((fine.width() + 1) / 2, (fine.height() + 1) / 2, Weighted::Zero());
  for (int v = 0; v < fine.height(); ++v) {
    for (int u = 0; u < fine.width(); ++u) coarse(u / 2, v / 2) += fine(u, v);
  }
  std::transform(coarse.begin(), coarse.end(), coarse.begin(), Saturated);
  return coarse;
}

// Of a level without gaps, at a cell of the next finer one: between the four nearest middles.
Weighted Between(const Image<Weighted>& coarse, int u, int v) {
  const auto at = [&](int x, int y) {
    return coarse(std::clamp(x, 0, coarse.width() - 1), std::clamp(y, 0, coarse.height() - 1));
  };
  const int beside_u = u % 2 == 0 ? u / 2 - 1 : u / 2 + 1;
  const int beside_v = v % 2 == 0 ? v / 2 - 1 : v / 2 + 1;
  return (9 * at(u / 2, v / 2) + 3 * at(beside_u, v / 2) + 3 * at(u / 2, beside_v) +
          at(beside_u, beside_v)) /
         16;
}

// What is missing of the cells comes from the coarser level.
void Push(const Image<Weighted>& coarse, Image<Weighted>& fine) {
  for (int v = 0; v < fine.height(); ++v) {
    for (int u = 0; u < fine.width(); ++u) {
      Weighted& cell = fine(u, v);
      if (cell.w() < 1) cell += (1 - cell.w()) * Between(coarse, u, v);
    }
  }
}

// To a weight of 1 everywhere.
void FillGaps(Image<Weighted>& cells) {
  std::vector<Image<Weighted>> levels{std::move(cells)};
  while (levels.back().size() > 1) levels.push_back(Pulled(levels.back()));
  Weighted& whole = levels.back()(0, 0);
  whole /= whole.w();
  for (std::size_t n = levels.size() - 1; n > 0; --n) Push(levels[n], levels[n - 1]);
  cells = std::move(levels.front());
}

std::uint8_t Byte(double value) {
  return static_cast<std::uint8_t>(std::lround(std::clamp(value, 0.0, 255.0)));
}

}  // namespace

ColourRaster::ColourRaster(const Eigen::AlignedBox2d& box_m, double step_m, std::size_t max_cells)
    : box_m_(box_m), step_m_(step_m) {
  DEEPSLAM_CHECK(!box_m.isEmpty() && step_m > 0 && max_cells > 0, "a raster covers something");
  const auto size = [&]() -> Eigen::Vector2d {
    return Steps(box_m_.max()) + Eigen::Vector2d::Ones();
  };
  while (size().prod() > static_cast<double>(max_cells)) step_m_ *= 1.25;
  sums_ = Image<Eigen::Vector4d>(
      static_cast<int>(size().x()), static_cast<int>(size().y()), Eigen::Vector4d::Zero());
}

Eigen::Vector2d ColourRaster::Steps(const Eigen::Vector2d& p_m) const {
  const auto whole = [&](const Eigen::Vector2d& at_m) -> Eigen::Vector2d {
    return (at_m / step_m_).array().round();
  };
  return whole(p_m) - whole(box_m_.min());
}

Eigen::Vector2i ColourRaster::CellOf(const Eigen::Vector2d& p_m) const {
  const Eigen::Vector2d steps = Steps(p_m);
  return {static_cast<int>(std::clamp(steps.x(), 0.0, sums_.width() - 1.0)),
          static_cast<int>(std::clamp(steps.y(), 0.0, sums_.height() - 1.0))};
}

void ColourRaster::Add(const Eigen::Vector2d& p_m, Rgb8 colour) {
  if (!box_m_.contains(p_m)) return;
  const Eigen::Vector2i cell = CellOf(p_m);
  sums_(cell.x(), cell.y()) += Eigen::Vector4d(colour.r, colour.g, colour.b, 1);
  ++num_added_;
}

Image<Rgb8> ColourRaster::Filled() const {
  DEEPSLAM_CHECK(!empty(), "an empty raster has no colours");
  Image<Weighted> cells = sums_;
  std::transform(cells.begin(), cells.end(), cells.begin(), Saturated);
  FillGaps(cells);
  Image<Rgb8> colours(cells.width(), cells.height());
  std::transform(cells.begin(), cells.end(), colours.begin(), [](const Weighted& cell) {
    return Rgb8{Byte(cell.x()), Byte(cell.y()), Byte(cell.z())};
  });
  return colours;
}

}  // namespace deepslam::mesh
