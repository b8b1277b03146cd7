#include "deepslam/layout/cell_complex.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <unordered_map>
#include <utility>

#include "deepslam/core/random.h"
#include "deepslam/geometry/box.h"

namespace deepslam::layout {
namespace {

constexpr double kMargin_m = 0.3;      // of the bounds around what was seen inside
constexpr double kShortest_m = 1e-6;   // edges below are where three lines meet
constexpr double kOpenHeight_m = 0.5;  // of a slot's rays through the face: it is open

// Of what was seen inside, along `axis` (u) and across it (v).
std::optional<Box2> BoundsOf(const ColumnMap& columns, const Eigen::Vector2d& axis) {
  const Eigen::Vector2d across(-axis.y(), axis.x());
  Box2 bounds{1e9, 1e9, -1e9, -1e9};
  for (int i = 0; i < columns.width; ++i) {
    for (int j = 0; j < columns.height; ++j) {
      if (!(columns.evidence[columns.IndexOf(i, j)] > 0)) continue;
      const Eigen::Vector2d p = columns.CentreOf(i, j);
      bounds = {std::min(bounds.u_min, axis.dot(p)),
                std::min(bounds.v_min, across.dot(p)),
                std::max(bounds.u_max, axis.dot(p)),
                std::max(bounds.v_max, across.dot(p))};
    }
  }
  if (bounds.empty()) return std::nullopt;
  return bounds;
}

WallLine Bound(const Eigen::Vector2d& inward, double offset_m) {
  WallLine line;
  line.normal = inward;
  line.offset_m = offset_m;
  return line;
}

// Cells are told apart by the sides of all lines they lie on: a sum of one random number per line.
class CellNames {
 public:
  explicit CellNames(const std::vector<WallLine>& lines) : lines_(lines) {
    Random random(1, "layout cells", 0);
    for (std::size_t n = 0; n < lines.size(); ++n) keys_.push_back(random.Next());
  }

  // The cell of a point; with `line`, the cell before (or behind) that line beside it.
  [[nodiscard]] std::uint64_t At(const Eigen::Vector2d& p,
                                 std::optional<std::size_t> line = {},
                                 bool front = true) const {
    std::uint64_t name = 0;
    for (std::size_t n = 0; n < lines_.size(); ++n) {
      const bool before = line && n == *line ? front : lines_[n].Distance(p) > 0;
      if (before) name ^= keys_[n];
    }
    return name;
  }
  std::size_t Number(std::uint64_t name, std::vector<GroundCell>& cells) {
    const auto [found, is_new] = numbers_.try_emplace(name, cells.size());
    if (is_new) cells.emplace_back();
    return found->second;
  }

 private:
  const std::vector<WallLine>& lines_;
  std::vector<std::uint64_t> keys_;
  std::unordered_map<std::uint64_t, std::size_t> numbers_;
};

bool WithinBounds(const CellComplex& complex, const Eigen::Vector2d& p, double margin_m) {
  for (std::size_t n = complex.num_wall_lines(); n < complex.lines.size(); ++n) {
    if (complex.lines[n].Distance(p) < margin_m) return false;
  }
  return true;
}

void AddColumns(const ColumnMap& columns, CellNames& names, CellComplex& complex) {
  const double area_m2 = columns.cell_m * columns.cell_m;
  for (int i = 0; i < columns.width; ++i) {
    for (int j = 0; j < columns.height; ++j) {
      const Eigen::Vector2d p = columns.CentreOf(i, j);
      if (!WithinBounds(complex, p, 0)) continue;
      const auto evidence = static_cast<double>(columns.evidence[columns.IndexOf(i, j)]);
      GroundCell& cell = complex.cells[names.Number(names.At(p), complex.cells)];
      cell.area_m2 += area_m2;
      cell.inside_m2 += evidence * area_m2;
      cell.unseen_m2 += evidence > 0 ? 0 : area_m2;
    }
  }
}

std::vector<double> CrossingsOf(const CellComplex& complex, std::size_t number) {
  const WallLine& line = complex.lines[number];
  std::vector<double> crossings_m;
  for (std::size_t n = 0; n < complex.lines.size(); ++n) {
    const WallLine& other = complex.lines[n];
    const double across = other.normal.dot(line.along());
    constexpr double kLeastSine = 1e-9;  // sine: lines that cross beyond any room, or nowhere
    if (n == number || std::abs(across) < kLeastSine) continue;
    crossings_m.push_back((other.offset_m - other.normal.dot(line.offset_m * line.normal)) /
                          across);
  }
  std::sort(crossings_m.begin(), crossings_m.end());
  return crossings_m;
}

double OpenShare(const WallProfile& profile, double from_m, double to_m) {
  const int first = static_cast<int>(std::lround((from_m - profile.begin_m) / kCell_m));
  const int end =
      std::max(first + 1, static_cast<int>(std::lround((to_m - profile.begin_m) / kCell_m)));
  int num_open = 0;
  for (int slot = std::max(first, 0); slot < std::min(end, profile.num_slots); ++slot) {
    if (profile.is_wall[static_cast<std::size_t>(slot)] != 0) continue;
    int rows = 0;
    for (int row = 0; row < profile.num_rows; ++row)
      rows += (profile.at(slot, row) & kOpen) != 0 ? 1 : 0;
    num_open += rows * kCell_m > kOpenHeight_m ? 1 : 0;
  }
  return static_cast<double>(num_open) / (end - first);
}

void AddEdges(std::size_t line, CellNames& names, CellComplex& complex) {
  const std::vector<double> crossings_m = CrossingsOf(complex, line);
  for (std::size_t n = 1; n < crossings_m.size(); ++n) {
    CellEdge edge;
    edge.line = line;
    edge.begin_m = crossings_m[n - 1];
    edge.end_m = crossings_m[n];
    if (edge.length_m() < kShortest_m) continue;
    const Eigen::Vector2d middle = complex.lines[line].At(0.5 * (edge.begin_m + edge.end_m));
    if (!WithinBounds(complex, middle, line < complex.num_wall_lines() ? 0 : -kShortest_m))
      continue;
    edge.front = names.Number(names.At(middle, line, true), complex.cells);
    edge.back = names.Number(names.At(middle, line, false), complex.cells);
    if (line < complex.num_wall_lines()) {
      const WallProfile& profile = complex.profiles[line];
      edge.wall_share = profile.WallShare(edge.begin_m, edge.end_m);
      edge.open_share = OpenShare(profile, edge.begin_m, edge.end_m);
    }
    complex.edges.push_back(edge);
  }
}

}  // namespace

CellComplex CutGround(std::vector<WallLine> lines,
                      std::vector<WallProfile> profiles,
                      const ColumnMap& columns) {
  CellComplex complex;
  // Along the walls: bounds across them would cut off corners of rooms that furniture hides.
  const Eigen::Vector2d axis = lines.empty() ? Eigen::Vector2d::UnitX() : lines.front().normal;
  const Eigen::Vector2d across(-axis.y(), axis.x());
  const std::optional<Box2> bounds = BoundsOf(columns, axis);
  if (!bounds) return complex;
  complex.lines = std::move(lines);
  complex.profiles = std::move(profiles);
  complex.lines.push_back(Bound(axis, bounds->u_min - kMargin_m));
  complex.lines.push_back(Bound(-axis, -bounds->u_max - kMargin_m));
  complex.lines.push_back(Bound(across, bounds->v_min - kMargin_m));
  complex.lines.push_back(Bound(-across, -bounds->v_max - kMargin_m));
  CellNames names(complex.lines);
  AddColumns(columns, names, complex);
  for (std::size_t line = 0; line < complex.lines.size(); ++line) AddEdges(line, names, complex);
  return complex;
}

}  // namespace deepslam::layout
