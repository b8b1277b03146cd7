#include "deepslam/synth/true_layout.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <map>
#include <optional>
#include <utility>

#include "deepslam/scene/layout.h"

namespace deepslam::synth {
namespace {

constexpr double kHighestSill_m = 0.05;  // what begins higher is a window
constexpr double kOnLine_m = 1e-6;       // coordinates that differ by rounding alone are one

using Corner = std::pair<std::size_t, std::size_t>;  // of the grid below

// The floor cut by every wall's faces: cells are free or within a partition.
class FloorGrid {
 public:
  explicit FloorGrid(const SceneDescription& description) {
    const Eigen::Vector2d half = description.room_size_m.head<2>() / 2;
    xs_ = {-half.x(), half.x()};
    ys_ = {-half.y(), half.y()};
    std::vector<std::pair<Eigen::Vector2d, Eigen::Vector2d>> slabs;
    for (const ScenePartition& partition : description.partitions) {
      const Eigen::Vector2d along = (partition.to_m - partition.from_m).normalized();
      const Eigen::Vector2d aside =
          0.5 * partition.thickness_m * Eigen::Vector2d(along.y(), along.x()).cwiseAbs();
      slabs.emplace_back((partition.from_m.cwiseMin(partition.to_m) - aside).cwiseMax(-half),
                         (partition.from_m.cwiseMax(partition.to_m) + aside).cwiseMin(half));
      xs_.insert(xs_.end(), {slabs.back().first.x(), slabs.back().second.x()});
      ys_.insert(ys_.end(), {slabs.back().first.y(), slabs.back().second.y()});
    }
    for (std::vector<double>* lines : {&xs_, &ys_}) {
      std::ranges::sort(*lines);
      const auto same = [](double a, double b) { return std::abs(a - b) < kOnLine_m; };
      lines->erase(std::unique(lines->begin(), lines->end(), same), lines->end());
    }
    room_of_.assign((xs_.size() - 1) * (ys_.size() - 1), kFree);
    for (const auto& [low, high] : slabs) Fill(low, high);
    NumberRooms();
  }

  [[nodiscard]] int num_rooms() const { return num_rooms_; }

  // Counter-clockwise; from the easternmost corner on, the southern one of several.
  [[nodiscard]] std::vector<Eigen::Vector2d> OutlineOf(int room) const {
    std::map<Corner, Corner> next;  // the room to the left
    for (std::size_t i = 0; i + 1 < xs_.size(); ++i) {
      for (std::size_t j = 0; j + 1 < ys_.size(); ++j) {
        if (At(i, j) != room) continue;
        if (At(i, j - 1) != room) next[{i, j}] = {i + 1, j};
        if (At(i + 1, j) != room) next[{i + 1, j}] = {i + 1, j + 1};
        if (At(i, j + 1) != room) next[{i + 1, j + 1}] = {i, j + 1};
        if (At(i - 1, j) != room) next[{i, j + 1}] = {i, j};
      }
    }
    Corner start = next.begin()->first;
    for (const auto& [corner, to] : next) {
      if (corner.first > start.first || (corner.first == start.first && corner < start))
        start = corner;
    }
    std::vector<Eigen::Vector2d> outline;
    Corner before = start, at = next.at(start);
    outline.push_back(Place(start));
    while (at != start) {
      const Corner& to = next.at(at);
      const bool straight = (before.first == at.first) == (at.first == to.first);
      if (!straight) outline.push_back(Place(at));
      before = std::exchange(at, to);
    }
    return outline;
  }

 private:
  static constexpr int kFree = -1;   // floor of no room yet
  static constexpr int kSolid = -2;  // within a partition

  [[nodiscard]] Eigen::Vector2d Place(const Corner& c) const {
    return {xs_[c.first], ys_[c.second]};
  }
  // Beyond the floor nothing is free; indices below 0 are huge.
  [[nodiscard]] int At(std::size_t i, std::size_t j) const {
    if (i >= xs_.size() - 1 || j >= ys_.size() - 1) return kSolid;
    return room_of_[i * (ys_.size() - 1) + j];
  }
  int& Cell(std::size_t i, std::size_t j) { return room_of_[i * (ys_.size() - 1) + j]; }

  void Fill(const Eigen::Vector2d& low, const Eigen::Vector2d& high) {
    for (std::size_t i = 0; i + 1 < xs_.size(); ++i) {
      for (std::size_t j = 0; j + 1 < ys_.size(); ++j) {
        const Eigen::Vector2d middle((xs_[i] + xs_[i + 1]) / 2, (ys_[j] + ys_[j + 1]) / 2);
        if ((middle.array() > low.array()).all() && (middle.array() < high.array()).all())
          Cell(i, j) = kSolid;
      }
    }
  }

  void NumberRooms() {
    for (std::size_t i = 0; i + 1 < xs_.size(); ++i) {
      for (std::size_t j = 0; j + 1 < ys_.size(); ++j) {
        if (At(i, j) == kFree) Flood({i, j}, num_rooms_++);
      }
    }
  }

  void Flood(const Corner& first, int room) {
    std::vector<Corner> open = {first};
    while (!open.empty()) {
      const auto [i, j] = open.back();
      open.pop_back();
      if (At(i, j) != kFree) continue;
      Cell(i, j) = room;
      open.insert(open.end(), {{i - 1, j}, {i + 1, j}, {i, j - 1}, {i, j + 1}});
    }
  }

  std::vector<double> xs_, ys_;
  std::vector<int> room_of_;
  int num_rooms_ = 0;
};

OpeningKind KindOf(const SceneOpening& opening) {
  if (opening.bottom_m > kHighestSill_m) return OpeningKind::kWindow;
  return opening.width_m > kWidestDoor_m ? OpeningKind::kPassage : OpeningKind::kDoor;
}

void AddRoom(const std::vector<Eigen::Vector2d>& outline, double ceiling_m, Layout& layout) {
  const int id = static_cast<int>(layout.rooms.size());
  LayoutRoom room;
  room.polygon_m = outline;
  room.guessed.assign(outline.size(), false);
  room.ceiling_m = ceiling_m;
  room.seen_share = 1;
  room.confidence = 1;
  layout.rooms.push_back(room);
  for (std::size_t n = 0; n < outline.size(); ++n) {
    LayoutWall wall;
    wall.from_m = outline[n];
    wall.to_m = outline[(n + 1) % outline.size()];
    wall.top_m = ceiling_m;
    wall.rooms = {id};
    wall.seen_share = 1;
    wall.confidence = 1;
    layout.walls.push_back(wall);
  }
}

// The wall whose face this stretch lies on.
std::optional<int> WallAt(const Layout& layout,
                          const Eigen::Vector2d& from_m,
                          const Eigen::Vector2d& to_m) {
  for (std::size_t n = 0; n < layout.walls.size(); ++n) {
    const LayoutWall& wall = layout.walls[n];
    const Eigen::Vector2d along = (wall.to_m - wall.from_m).normalized();
    const auto on = [&](const Eigen::Vector2d& p) {
      const Eigen::Vector2d away = p - wall.from_m;
      const double at_m = away.dot(along);
      return (away - at_m * along).norm() < kOnLine_m && at_m > -kOnLine_m &&
             at_m < wall.length_m() + kOnLine_m;
    };
    if (on(from_m) && on(to_m)) return static_cast<int>(n);
  }
  return std::nullopt;
}

void AddOpening(const SceneOpening& gap,
                const Eigen::Vector2d& a_m,
                const Eigen::Vector2d& b_m,
                const std::optional<Eigen::Vector2d>& to_other_face,
                Layout& layout) {
  const std::optional<int> number = WallAt(layout, a_m, b_m);
  if (!number) return;  // a stretch that another partition covers
  const LayoutWall& wall = layout.walls[static_cast<std::size_t>(*number)];
  LayoutOpening opening;
  opening.wall = *number;
  opening.kind = KindOf(gap);
  const bool as_the_wall = (b_m - a_m).dot(wall.to_m - wall.from_m) > 0;
  opening.from_m = as_the_wall ? a_m : b_m;
  opening.to_m = as_the_wall ? b_m : a_m;
  opening.bottom_m = gap.bottom_m;
  opening.top_m = gap.bottom_m + gap.height_m;
  opening.rooms = wall.rooms;
  if (to_other_face) {
    const auto behind = WallAt(layout, a_m + *to_other_face, b_m + *to_other_face);
    if (behind)
      opening.rooms.push_back(layout.walls[static_cast<std::size_t>(*behind)].rooms.front());
  }
  opening.confidence = 1;
  layout.openings.push_back(opening);
}

// The left end of a wall of the whole room as one sees it from inside, and where it runs to.
std::pair<Eigen::Vector2d, Eigen::Vector2d> OuterWall(const SceneDescription& description,
                                                      int number) {
  const double x = description.room_size_m.x() / 2;
  const double y = description.room_size_m.y() / 2;
  const std::array<Eigen::Vector2d, 4> corners = {
      Eigen::Vector2d(x, y), {-x, y}, {-x, -y}, {x, -y}};  // east, north, west, south
  const auto n = static_cast<std::size_t>(number);
  return {corners[n], (corners[(n + 3) % 4] - corners[n]).normalized()};
}

}  // namespace

Layout TrueLayout(const SceneDescription& description) {
  const FloorGrid grid(description);
  const double ceiling_m = description.room_size_m.z();
  Layout layout;
  double area_m2 = 0;
  for (int room = 0; room < grid.num_rooms(); ++room) {
    AddRoom(grid.OutlineOf(room), ceiling_m, layout);
    area_m2 += AreaOf(layout.rooms.back().polygon_m);
  }
  layout.levels = {{LevelKind::kFloor, 0, area_m2}, {LevelKind::kCeiling, ceiling_m, area_m2}};
  for (const SceneOpening& gap : description.openings) {
    const auto [left, along] = OuterWall(description, gap.wall);
    AddOpening(gap,
               left + gap.from_m * along,
               left + (gap.from_m + gap.width_m) * along,
               std::nullopt,
               layout);
  }
  for (const ScenePartition& partition : description.partitions) {
    const Eigen::Vector2d along = (partition.to_m - partition.from_m).normalized();
    const Eigen::Vector2d aside =
        0.5 * partition.thickness_m * Eigen::Vector2d(along.y(), -along.x());
    for (const SceneOpening& gap : partition.openings) {
      const Eigen::Vector2d from = partition.from_m + gap.from_m * along + aside;
      AddOpening(gap, from, from + gap.width_m * along, Eigen::Vector2d(-2 * aside), layout);
    }
  }
  return layout;
}

}  // namespace deepslam::synth
