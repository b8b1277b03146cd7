#include "deepslam/eval/box_score.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "deepslam/geometry/level_rectangle.h"

namespace deepslam::eval {
namespace {

LevelRectangle OutlineOf(const PlacedBox& box) {
  const Eigen::Vector3d front = box.world_from_object.rotation * Eigen::Vector3d::UnitX();
  return {box.world_from_object.translation_m.head<2>(),
          std::atan2(front.y(), front.x()),
          box.size_m.x(),
          box.size_m.y()};
}

bool Holds(const PlacedBox& box, const Eigen::Vector3d& p_world) {
  const double above_m = p_world.z() - box.world_from_object.translation_m.z();
  return std::abs(above_m) <= box.size_m.z() / 2 && OutlineOf(box).Contains(p_world.head<2>());
}

double Share(int part, int whole) { return whole > 0 ? static_cast<double>(part) / whole : 1.0; }

}  // namespace

double BoxIou(const PlacedBox& a, const PlacedBox& b) {
  const auto bottom = [](const PlacedBox& box) {
    return box.world_from_object.translation_m.z() - box.size_m.z() / 2;
  };
  const double height_m =
      std::min(bottom(a) + a.size_m.z(), bottom(b) + b.size_m.z()) - std::max(bottom(a), bottom(b));
  if (height_m <= 0) return 0;
  const double shared_m3 = height_m * SharedArea(OutlineOf(a), OutlineOf(b));
  const double all_m3 = a.size_m.prod() + b.size_m.prod() - shared_m3;
  return all_m3 > 0 ? std::clamp(shared_m3 / all_m3, 0.0, 1.0) : 0;
}

std::vector<PlacedBoxMatch> MatchPlacedBoxes(std::span<const PlacedBox> estimated,
                                             std::span<const PlacedBox> truth) {
  std::vector<PlacedBoxMatch> pairs;
  for (std::size_t t = 0; t < truth.size(); ++t) {
    for (std::size_t e = 0; e < estimated.size(); ++e) {
      const double iou = BoxIou(estimated[e], truth[t]);
      if (iou > 0) pairs.push_back({e, t, iou});
    }
  }
  std::ranges::sort(pairs, {}, [](const PlacedBoxMatch& pair) {
    return std::tuple(-pair.iou, pair.truth, pair.estimated);
  });
  std::vector<char> truth_taken(truth.size(), 0);
  std::vector<char> estimated_taken(estimated.size(), 0);
  std::vector<PlacedBoxMatch> matches;
  for (const PlacedBoxMatch& pair : pairs) {
    if (truth_taken[pair.truth] != 0 || estimated_taken[pair.estimated] != 0) continue;
    truth_taken[pair.truth] = 1;
    estimated_taken[pair.estimated] = 1;
    matches.push_back(pair);
  }
  std::ranges::sort(matches, {}, &PlacedBoxMatch::truth);
  return matches;
}

double BoxScore::recall() const { return Share(num_found, num_true); }
double BoxScore::recall_right_class() const { return Share(num_right_class, num_true); }
double BoxScore::precision() const { return Share(num_found, num_estimated); }
double BoxScore::precision_right_class() const { return Share(num_right_class, num_estimated); }

BoxScore& BoxScore::operator+=(const BoxScore& other) {
  num_true += other.num_true;
  num_estimated += other.num_estimated;
  num_found += other.num_found;
  num_right_class += other.num_right_class;
  return *this;
}

BoxScore ScoreBoxes(std::span<const PlacedBox> estimated,
                    std::span<const PlacedBox> truth,
                    std::span<const PlacedBoxMatch> matches,
                    double min_iou) {
  BoxScore score;
  score.min_iou = min_iou;
  score.num_true = static_cast<int>(truth.size());
  score.num_estimated = static_cast<int>(estimated.size());
  for (const PlacedBoxMatch& match : matches) {
    if (match.iou < min_iou) continue;
    ++score.num_found;
    if (estimated[match.estimated].class_name == truth[match.truth].class_name)
      ++score.num_right_class;
  }
  return score;
}

Confusions CountConfusions(std::span<const PlacedBox> estimated,
                           std::span<const PlacedBox> truth,
                           std::span<const PlacedBoxMatch> matches,
                           double min_iou) {
  Confusions confusions;
  for (const PlacedBoxMatch& match : matches) {
    const std::string& mapped = estimated[match.estimated].class_name;
    const std::string& right = truth[match.truth].class_name;
    if (match.iou >= min_iou && mapped != right) ++confusions[{right, mapped}];
  }
  return confusions;
}

std::vector<std::size_t> HoldersOfSeveral(std::span<const PlacedBox> holders,
                                          std::span<const PlacedBox> held,
                                          std::span<const PlacedBoxMatch> matches,
                                          double min_iou) {
  std::vector<std::size_t> holder_of(held.size(), holders.size());
  for (const PlacedBoxMatch& match : matches) {
    if (match.iou >= min_iou) holder_of[match.truth] = match.estimated;
  }
  std::vector<std::size_t> several;
  for (std::size_t n = 0; n < holders.size(); ++n) {
    int num_held = 0;
    for (std::size_t k = 0; k < held.size(); ++k) {
      const bool is_anothers = holder_of[k] != holders.size() && holder_of[k] != n;
      if (!is_anothers && Holds(holders[n], held[k].world_from_object.translation_m)) ++num_held;
    }
    if (num_held > 1) several.push_back(n);
  }
  return several;
}

std::vector<PlacedBoxMatch> Turned(std::span<const PlacedBoxMatch> matches) {
  std::vector<PlacedBoxMatch> turned;
  for (const PlacedBoxMatch& match : matches)
    turned.push_back({match.truth, match.estimated, match.iou});
  return turned;
}

}  // namespace deepslam::eval
