// Which mapped object is which true one, and how well it stands where it should.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "deepslam/core/options.h"
#include "deepslam/geometry/pose.h"
#include "deepslam/shape/symmetry.h"

namespace deepslam::eval {

inline constexpr std::string_view kPlacementProtocol =
    "scan2cad placement: 20 cm, 20 deg, 20 % (mean ratio of sides), rotation by the shape's "
    "symmetry";

// An object's box and pose: origin at the middle of its box, axes along it, z up, x front.
struct PlacedBox {
  std::string class_name;
  Pose3 world_from_object;
  Eigen::Vector3d size_m = Eigen::Vector3d::Zero();
};

struct PlacementOptions {
  double max_match_m = 0.5;  // between the centres of a true object and the mapped one taken for it
  double max_translation_m = 0.2;
  double max_rotation_deg = 20;
  double max_scale_percent = 20;
};
void Describe(OptionsVisitor& visitor, PlacementOptions& options);

struct PlacementError {
  double translation_m = 0;
  double rotation_deg = 0;   // least over the truth's symmetry
  double scale_percent = 0;  // mean ratio of the three sides, less 1, absolute
  bool correct = false;      // all three within the limits
};
[[nodiscard]] PlacementError ComparePlacement(const PlacedBox& estimated,
                                              const PlacedBox& truth,
                                              shape::Symmetry symmetry,
                                              const PlacementOptions& options);

// A truth that is a box alone has no front, and which of its sides its x axis lies along says
// nothing: the estimated box with x and y exchanged where its sides are more like the truth's so.
[[nodiscard]] PlacedBox WithAxesAlongLikeSides(PlacedBox estimated, const PlacedBox& truth);

// Quarter turns about z that bring the estimated object's axes nearest to those of the truth: its
// shape, so turned, lies as it stands in the world.
[[nodiscard]] int QuarterTurnsAsPlaced(const Pose3& world_from_estimated,
                                       const Pose3& world_from_true);

struct Match {
  std::size_t estimated = 0;
  std::size_t truth = 0;
  double distance_m = 0;  // between the centres
  bool same_class = false;
};
// Nearest pairs first, each object once; pairs of one class before all others, which tell what a
// wrongly named object was. Ordered by truth.
[[nodiscard]] std::vector<Match> MatchObjects(std::span<const PlacedBox> estimated,
                                              std::span<const PlacedBox> truth,
                                              const PlacementOptions& options);

struct ClassCounts {
  std::string class_name;
  int num_true = 0;
  int num_estimated = 0;
  int num_found = 0;                       // matched and of the same class
  [[nodiscard]] double precision() const;  // 1 where nothing was claimed
  [[nodiscard]] double recall() const;     // 1 where nothing was there
};
// Ascending class names.
[[nodiscard]] std::vector<ClassCounts> CountByClass(std::span<const PlacedBox> estimated,
                                                    std::span<const PlacedBox> truth,
                                                    std::span<const Match> matches);

}  // namespace deepslam::eval
