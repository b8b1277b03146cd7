#include "deepslam/loop/feature_pose.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include "deepslam/core/random.h"
#include "deepslam/core/wide_vectors.h"

namespace deepslam::loop {
namespace {

// How near the nearest descriptor has to be, and how much nearer than the second nearest.
struct Distinctness {
  float ratio = 1;
  int max_distance = std::numeric_limits<int>::max();
};
constexpr Distinctness kOfCorners{0.85F, 70};      // unequal bits
constexpr Distinctness kOfGradients{0.8F * 0.8F};  // of squared distances; Lowe 2004
constexpr float kAngle_rad = 0.01F;                // of the ray: 5 px of a 640 px wide image
// Of a corner's depth when near; grows with the square, as disparity's.
constexpr float kDepthBase_m = 0.03F;
constexpr float kDepthGrowth = 0.015F;  // 1 / m
constexpr int kMaxTrials = 500;        // with a quarter of the matches right, 99.9 % sure after 439
constexpr double kSureOfPose = 0.999;  // that the best sample was drawn
constexpr int kPoseRefits = 4;         // fits to all inliers; few change after two
constexpr float kMinSide_m = 0.15F;    // of a sample's triangle
// A rival pose that is nearly the same is no rival.
constexpr double kSamePose_m = 0.15;
constexpr double kSamePose_rad = 0.1;  // the same for the turn

struct Match {
  Eigen::Vector3f old_m;
  Eigen::Vector3f new_m;
};
using Matches = std::vector<Match>;

// The nearest of all that a descriptor was held against, the first of several, and how near the
// second nearest is.
struct Nearest {
  int row = -1;
  int distance = std::numeric_limits<int>::max();
  int second_distance = std::numeric_limits<int>::max();

  void Hold(int other, int other_distance) {
    if (other_distance < distance) {
      second_distance = std::exchange(distance, other_distance);
      row = other;
    } else {
      second_distance = std::min(second_distance, other_distance);
    }
  }

  // Whether the second nearest is not as good.
  [[nodiscard]] bool IsDistinct(const Distinctness& least) const {
    return distance <= least.max_distance &&
           static_cast<float>(distance) <= least.ratio * static_cast<float>(second_distance);
  }
};

struct NearestBothWays {
  std::vector<Nearest> of_old;
  std::vector<Nearest> of_new;
};

template <typename Descriptor>
NearestBothWays Compare(std::span<const Descriptor> olds, std::span<const Descriptor> news) {
  NearestBothWays nearest{std::vector<Nearest>(olds.size()), std::vector<Nearest>(news.size())};
  for (std::size_t n = 0; n < news.size(); ++n) {
    for (std::size_t o = 0; o < olds.size(); ++o) {
      const int distance = Distance(olds[o], news[n]);
      nearest.of_new[n].Hold(static_cast<int>(o), distance);
      nearest.of_old[o].Hold(static_cast<int>(n), distance);
    }
  }
  return nearest;
}

DEEPSLAM_WIDE_VECTORS
NearestBothWays FindNearest(std::span<const BinaryDescriptor> olds,
                            std::span<const BinaryDescriptor> news) {
  return Compare(olds, news);
}

DEEPSLAM_WIDE_VECTORS
NearestBothWays FindNearest(std::span<const GradientDescriptor> olds,
                            std::span<const GradientDescriptor> news) {
  return Compare(olds, news);
}

template <typename Descriptor>
Matches MutualMatches(const FeaturesOf<Descriptor>& old_features,
                      const FeaturesOf<Descriptor>& new_features,
                      const Distinctness& least) {
  if (old_features.descriptors.size() < 2 || new_features.descriptors.size() < 2) return {};
  const NearestBothWays nearest =
      FindNearest(std::span(old_features.descriptors), std::span(new_features.descriptors));
  Matches matches;
  for (std::size_t k = 0; k < nearest.of_new.size(); ++k) {
    if (!nearest.of_new[k].IsDistinct(least)) continue;
    const auto other = static_cast<std::size_t>(nearest.of_new[k].row);
    const Nearest& back = nearest.of_old[other];
    if (!back.IsDistinct(least) || back.row != static_cast<int>(k)) continue;
    matches.push_back({old_features.points_camera[other], new_features.points_camera[k]});
  }
  return matches;
}

float DepthTolerance(float depth_m) { return kDepthBase_m + kDepthGrowth * depth_m * depth_m; }

bool Agrees(const Eigen::Isometry3f& old_from_new, const Match& match) {
  const Eigen::Vector3f moved = old_from_new * match.new_m;
  if (moved.z() <= 0.05F) return false;
  if (std::abs(moved.z() - match.old_m.z()) > DepthTolerance(match.old_m.z())) return false;
  const Eigen::Vector2f difference =
      moved.head<2>() / moved.z() - match.old_m.head<2>() / match.old_m.z();
  return difference.squaredNorm() < kAngle_rad * kAngle_rad;
}

std::vector<std::size_t> Inliers(const Eigen::Isometry3f& old_from_new, const Matches& matches) {
  std::vector<std::size_t> inliers;
  for (std::size_t k = 0; k < matches.size(); ++k) {
    if (Agrees(old_from_new, matches[k])) inliers.push_back(k);
  }
  return inliers;
}

std::optional<Eigen::Isometry3f> Fit(const Matches& matches, std::span<const std::size_t> members) {
  const auto count = static_cast<Eigen::Index>(members.size());
  Eigen::Matrix3Xd from(3, count);
  Eigen::Matrix3Xd to(3, count);
  for (Eigen::Index k = 0; k < count; ++k) {
    from.col(k) = matches[members[static_cast<std::size_t>(k)]].new_m.cast<double>();
    to.col(k) = matches[members[static_cast<std::size_t>(k)]].old_m.cast<double>();
  }
  const Eigen::Matrix4d fitted = Eigen::umeyama(from, to, false);
  if (!fitted.allFinite()) return std::nullopt;
  return Eigen::Isometry3f(fitted.cast<float>());
}

// Whether the triangle has the same sides in both frames and is not too small.
bool Rigid(const Matches& matches, const std::array<std::size_t, 3>& sample) {
  for (std::size_t k = 0; k < 3; ++k) {
    const Match& a = matches[sample[k]];
    const Match& b = matches[sample[(k + 1) % 3]];
    const float old_side_m = (a.old_m - b.old_m).norm();
    const float new_side_m = (a.new_m - b.new_m).norm();
    const float tolerance_m = DepthTolerance(std::max(a.old_m.z(), b.old_m.z()));
    if (old_side_m < kMinSide_m || std::abs(old_side_m - new_side_m) > 2 * tolerance_m)
      return false;
  }
  return true;
}

struct Consensus {
  Eigen::Isometry3f old_from_new = Eigen::Isometry3f::Identity();
  std::vector<std::size_t> inliers;
};

int TrialsFor(std::size_t num_inliers, std::size_t num_matches) {
  const double share = static_cast<double>(num_inliers) / static_cast<double>(num_matches);
  const double miss = 1.0 - share * share * share;
  if (miss <= 1e-9) return 1;
  const double trials = std::log(1.0 - kSureOfPose) / std::log(miss);
  return static_cast<int>(std::min<double>(kMaxTrials, std::ceil(trials)));
}

Consensus Ransac(const Matches& matches, Random& random) {
  Consensus best;
  int trials = matches.size() < 3 ? 0 : kMaxTrials;
  for (int trial = 0; trial < trials; ++trial) {
    const std::array<std::size_t, 3> sample = {
        random.Index(matches.size()), random.Index(matches.size()), random.Index(matches.size())};
    if (!Rigid(matches, sample)) continue;
    const std::optional<Eigen::Isometry3f> fitted = Fit(matches, sample);
    if (!fitted) continue;
    std::vector<std::size_t> inliers = Inliers(*fitted, matches);
    if (inliers.size() <= best.inliers.size()) continue;
    best = {*fitted, std::move(inliers)};
    trials = std::min(trials, trial + 1 + TrialsFor(best.inliers.size(), matches.size()));
  }
  for (int k = 0; k < kPoseRefits && best.inliers.size() >= 3; ++k) {
    const std::optional<Eigen::Isometry3f> fitted = Fit(matches, best.inliers);
    if (!fitted) break;
    std::vector<std::size_t> inliers = Inliers(*fitted, matches);
    if (inliers.size() < best.inliers.size()) break;
    best = {*fitted, std::move(inliers)};
  }
  return best;
}

Pose3 ToPose(const Eigen::Isometry3f& b_from_a) {
  return {Eigen::Quaterniond(b_from_a.rotation().cast<double>()).normalized(),
          b_from_a.translation().cast<double>()};
}

double Spread(const Matches& matches,
              const std::vector<std::size_t>& members,
              Eigen::Vector3f Match::*point) {
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  Eigen::Matrix2d squares = Eigen::Matrix2d::Zero();
  for (const std::size_t k : members) {
    const Eigen::Vector3d p = (matches[k].*point).cast<double>();
    const Eigen::Vector2d direction = p.head<2>() / p.z();
    mean += direction;
    squares += direction * direction.transpose();
  }
  const auto count = static_cast<double>(members.size());
  mean /= count;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(squares / count -
                                                              mean * mean.transpose());
  return std::sqrt(std::max(0.0, solver.eigenvalues()[0]));
}

// The matches that agree with one another pose.
int Rivals(const Matches& matches, const Consensus& winner, const Pose3& pose, Random& random) {
  Matches others;
  std::size_t next = 0;
  for (std::size_t k = 0; k < matches.size(); ++k) {
    if (next < winner.inliers.size() && winner.inliers[next] == k) {
      ++next;
    } else {
      others.push_back(matches[k]);
    }
  }
  const Consensus rival = Ransac(others, random);
  if (rival.inliers.empty()) return 0;
  const Pose3 between = pose.Inverse() * ToPose(rival.old_from_new);
  const bool same =
      between.translation_m.norm() < kSamePose_m && RotationAngle(between.rotation) < kSamePose_rad;
  return same ? 0 : static_cast<int>(rival.inliers.size());
}

// `item` draws the samples.
std::optional<FeaturePose> PoseFromMatches(const Matches& matches,
                                           int min_inliers,
                                           std::pair<FrameIdx, FrameIdx> item) {
  const auto least = static_cast<std::size_t>(std::max(4, min_inliers));
  if (matches.size() < least) return std::nullopt;
  Random random(static_cast<std::uint64_t>(item.first.value),
                "feature pose",
                static_cast<std::uint64_t>(item.second.value));
  const Consensus consensus = Ransac(matches, random);
  if (consensus.inliers.size() < least) return std::nullopt;
  FeaturePose pose;
  pose.old_from_new = ToPose(consensus.old_from_new);
  pose.num_inliers = static_cast<int>(consensus.inliers.size());
  pose.num_rivals = Rivals(matches, consensus, pose.old_from_new, random);
  pose.spread_rad = std::min(Spread(matches, consensus.inliers, &Match::old_m),
                             Spread(matches, consensus.inliers, &Match::new_m));
  return pose;
}

}  // namespace

std::optional<FeaturePose> PoseFromFeatures(const KeyframeFeatures& old_features,
                                            const KeyframeFeatures& new_features,
                                            int min_inliers) {
  return PoseFromMatches(MutualMatches(old_features, new_features, kOfCorners),
                         min_inliers,
                         {old_features.keyframe, new_features.keyframe});
}

std::optional<FeaturePose> PoseFromFeatures(const GradientFeatures& old_features,
                                            const GradientFeatures& new_features,
                                            int min_inliers) {
  return PoseFromMatches(MutualMatches(old_features, new_features, kOfGradients),
                         min_inliers,
                         {old_features.keyframe, new_features.keyframe});
}

}  // namespace deepslam::loop
