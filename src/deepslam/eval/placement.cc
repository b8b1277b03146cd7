#include "deepslam/eval/placement.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <tuple>

#include "deepslam/core/angles.h"

namespace deepslam::eval {

void Describe(OptionsVisitor& visitor, PlacementOptions& options) {
  visitor.Field("max_match_m",
                options.max_match_m,
                {0.01, 100.0},
                "m",
                "between the centres of a true object and the mapped one taken for it");
  visitor.Field(
      "max_translation_m", options.max_translation_m, {0.0, 100.0}, "m", "of a right placement");
  visitor.Field(
      "max_rotation_deg", options.max_rotation_deg, {0.0, 180.0}, "deg", "of a right placement");
  visitor.Field(
      "max_scale_percent", options.max_scale_percent, {0.0, 1000.0}, "1", "of a right placement");
}

PlacedBox WithAxesAlongLikeSides(PlacedBox estimated, const PlacedBox& truth) {
  const Eigen::Vector2d true_m = truth.size_m.head<2>();
  const auto difference = [&](const Eigen::Vector2d& sides_m) {
    return sides_m.cwiseQuotient(true_m).array().log().abs().sum();
  };
  const Eigen::Vector2d sides_m = estimated.size_m.head<2>();
  const Eigen::Vector2d exchanged_m = sides_m.reverse();
  if (difference(sides_m) <= difference(exchanged_m)) return estimated;
  estimated.size_m.head<2>() = exchanged_m;
  const Eigen::AngleAxisd quarter(std::numbers::pi / 2, Eigen::Vector3d::UnitZ());
  estimated.world_from_object.rotation = estimated.world_from_object.rotation * quarter;
  return estimated;
}

int QuarterTurnsAsPlaced(const Pose3& world_from_estimated, const Pose3& world_from_true) {
  const Eigen::Vector3d front = world_from_true.rotation.conjugate() *
                                (world_from_estimated.rotation * Eigen::Vector3d::UnitX());
  const double quarters = std::atan2(front.y(), front.x()) / (std::numbers::pi / 2);
  return (static_cast<int>(std::lround(quarters)) + 4) % 4;
}

PlacementError ComparePlacement(const PlacedBox& estimated,
                                const PlacedBox& truth,
                                shape::Symmetry symmetry,
                                const PlacementOptions& options) {
  PlacementError error;
  error.translation_m =
      (estimated.world_from_object.translation_m - truth.world_from_object.translation_m).norm();
  error.rotation_deg =
      kDegPerRad * shape::RotationApart(truth.world_from_object.rotation.conjugate() *
                                            estimated.world_from_object.rotation,
                                        symmetry);
  Eigen::Vector3d size = estimated.size_m;
  if (QuarterTurnsAsPlaced(estimated.world_from_object, truth.world_from_object) % 2 != 0)
    std::swap(size.x(), size.y());
  error.scale_percent = 100 * std::abs(size.cwiseQuotient(truth.size_m).mean() - 1);
  error.correct = error.translation_m <= options.max_translation_m &&
                  error.rotation_deg <= options.max_rotation_deg &&
                  error.scale_percent <= options.max_scale_percent;
  return error;
}

std::vector<Match> MatchObjects(std::span<const PlacedBox> estimated,
                                std::span<const PlacedBox> truth,
                                const PlacementOptions& options) {
  std::vector<Match> pairs;
  for (std::size_t t = 0; t < truth.size(); ++t) {
    for (std::size_t e = 0; e < estimated.size(); ++e) {
      const double distance =
          (estimated[e].world_from_object.translation_m - truth[t].world_from_object.translation_m)
              .norm();
      if (distance <= options.max_match_m)
        pairs.push_back({e, t, distance, estimated[e].class_name == truth[t].class_name});
    }
  }
  std::sort(pairs.begin(), pairs.end(), [](const Match& a, const Match& b) {
    return std::tuple(!a.same_class, a.distance_m, a.truth, a.estimated) <
           std::tuple(!b.same_class, b.distance_m, b.truth, b.estimated);
  });
  std::vector<char> truth_taken(truth.size(), 0);
  std::vector<char> estimated_taken(estimated.size(), 0);
  std::vector<Match> matches;
  for (const Match& pair : pairs) {
    if (truth_taken[pair.truth] != 0 || estimated_taken[pair.estimated] != 0) continue;
    truth_taken[pair.truth] = 1;
    estimated_taken[pair.estimated] = 1;
    matches.push_back(pair);
  }
  std::sort(matches.begin(), matches.end(), [](const Match& a, const Match& b) {
    return a.truth < b.truth;
  });
  return matches;
}

double ClassCounts::precision() const {
  return num_estimated > 0 ? static_cast<double>(num_found) / num_estimated : 1.0;
}

double ClassCounts::recall() const {
  return num_true > 0 ? static_cast<double>(num_found) / num_true : 1.0;
}

std::vector<ClassCounts> CountByClass(std::span<const PlacedBox> estimated,
                                      std::span<const PlacedBox> truth,
                                      std::span<const Match> matches) {
  std::map<std::string, ClassCounts> counts;
  for (const PlacedBox& object : truth) ++counts[object.class_name].num_true;
  for (const PlacedBox& object : estimated) ++counts[object.class_name].num_estimated;
  for (const Match& match : matches) {
    if (match.same_class) ++counts[truth[match.truth].class_name].num_found;
  }
  std::vector<ClassCounts> list;
  for (auto& [name, count] : counts) {
    count.class_name = name;
    list.push_back(count);
  }
  return list;
}

}  // namespace deepslam::eval
