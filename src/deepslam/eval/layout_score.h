// Walls, rooms and openings of a layout against true ones.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "deepslam/scene/layout.h"

namespace deepslam::eval {

inline constexpr std::string_view kLayoutProtocol =
    "walls within 10 cm and 5 deg over 60 % of the length that was seen (true walls of 1 m seen "
    "and "
    "more count); corners to the nearest; openings by kind at IoU 0.5 in the wall's plane";

// A wall as it is known: a face, or a box around one whose faces lie somewhere within it.
struct TrueWall {
  Eigen::Vector2d from_m =
      Eigen::Vector2d::Zero();  // ends of the face, or of the box's middle line
  Eigen::Vector2d to_m = Eigen::Vector2d::Zero();
  double thickness_m = 0;  // of the box
  double bottom_m = 0;
  double top_m = 0;
};

struct TrueOpening {
  OpeningKind kind = OpeningKind::kDoor;
  Eigen::Vector2d from_m = Eigen::Vector2d::Zero();
  Eigen::Vector2d to_m = Eigen::Vector2d::Zero();
  double thickness_m = 0;  // of its box: of a door that stands open, the width of its leaf
  double bottom_m = 0;
  double top_m = 0;
};

struct TrueLayout {
  std::vector<TrueWall> walls;
  std::vector<TrueOpening> openings;
  std::vector<std::vector<Eigen::Vector2d>> rooms;  // polygons; none: rooms are not scored
};

struct LayoutScoreOptions {
  double max_distance_m = 0.10;
  double max_angle_deg = 5;
  double min_share = 0.6;
  double min_wall_m = 1.0;  // of a true wall that was seen
  double min_opening_iou = 0.5;
  double max_opening_depth_m = 0.3;  // between an opening's wall and the true opening
};

struct KindScore {
  OpeningKind kind = OpeningKind::kDoor;
  int num_true = 0;
  int num_estimated = 0;
  int num_found = 0;
  [[nodiscard]] double precision() const;  // 1 where nothing was claimed
  [[nodiscard]] double recall() const;     // 1 where nothing was there
  [[nodiscard]] double f1() const;
};

struct LayoutScore {
  int num_true_walls = 0;  // of which enough was seen
  int num_found_walls = 0;
  int num_walls = 0;
  int num_right_walls = 0;
  std::vector<int> missed_walls;  // positions among the true ones
  std::vector<int> wrong_walls;   // positions among the estimated ones
  std::vector<double> corner_m;   // of each true corner whose walls were seen there, to the nearest
  // Of each true room that was found: |area - true area| / true area.
  std::vector<double> room_area_error;
  int num_true_rooms = 0;
  std::vector<KindScore> openings;  // door, window, passage
  int num_openings_any_kind = 0;    // true openings found, whatever they were called

  [[nodiscard]] double wall_recall() const;
  [[nodiscard]] double wall_precision() const;
};

// `layout` in the true world. What was seen of a true wall is where `seen_points` (of the measured
// surface, in the true world) lie in it.
[[nodiscard]] LayoutScore ScoreLayout(const Layout& layout,
                                      const TrueLayout& truth,
                                      const std::vector<Eigen::Vector3d>& seen_points,
                                      const LayoutScoreOptions& options);

}  // namespace deepslam::eval
