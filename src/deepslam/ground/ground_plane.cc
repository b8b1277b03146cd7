#include "deepslam/ground/ground_plane.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <Eigen/Cholesky>

#include "deepslam/core/angles.h"
#include "deepslam/core/order_statistics.h"
#include "deepslam/core/parallel.h"
#include "deepslam/core/random.h"
#include "deepslam/ground/floor_patches.h"
#include "deepslam/ground/ground_points.h"
#include "deepslam/ground/held_camera.h"
#include "deepslam/ground/level_search.h"
#include "deepslam/ground/plane_fit.h"
#include "deepslam/ground/reidentify.h"
#include "deepslam/scene/measured_parts.h"

namespace deepslam::ground {
namespace {

// Read and searched side by side; bounds what is held in memory.
constexpr std::size_t kBatchKeyframes = 16;
// Of each keyframe, of long paths fewer: 12 bytes each, and 24 MB are enough.
constexpr std::size_t kMostSamplePoints = 400;
constexpr std::size_t kLeastSamplePoints = 20;       // fewer would not show a floor beside a table
constexpr std::size_t kAllSamplePoints = 2'000'000;  // of all keyframes together
// Keyframes on either side whose samples say what lies below a plane found again; tracking drifts
// by little between them.
constexpr std::size_t kKeyframesAbout = 10;
// A lower plane must hold this share of the largest one.
constexpr double kMinShareOfLargest = 0.15;
// How far the propagated plane may be off after one more keyframe: drift of tracking, one standard
// deviation.
constexpr double kStepAngleRad = 0.5 * kRadPerDeg;
constexpr double kStepDistanceM = 0.01;  // m: the same for the height
// Drift of tracking between an observation and the world, one standard deviation, for the common
// plane.
constexpr double kDriftAngleRad = 1.0 * kRadPerDeg;
constexpr double kDriftDistanceM = 0.02;  // m: the same for the height

constexpr std::array<std::string_view, 5> kTurnsDeg = {"auto", "0", "90", "180", "270"};
constexpr std::array kTurns = {QuarterTurn::kNone,
                               QuarterTurn::kClockwise,
                               QuarterTurn::kHalf,
                               QuarterTurn::kAnticlockwise};  // behind `auto`

bool HasPose(const TrackedFrame& frame) {
  return IsAligned(frame) || frame.keyframe == frame.frame;
}

Eigen::Matrix3d WithAddedError(const Eigen::Matrix3d& information,
                               double angle_rad,
                               double distance_m) {
  const Eigen::Matrix3d covariance =
      information.inverse() + InformationOf(angle_rad, distance_m).inverse();
  return covariance.inverse();
}

// (tangent directions at a, distance) that lead from plane a to plane b.
Eigen::Vector3d Difference(const Plane& a, const Plane& b) {
  Eigen::Vector3d difference;
  difference << GroundTangentBasis(a.normal).transpose() * b.normal, b.d_m - a.d_m;
  return difference;
}

// How far the search over all parts has come, in keyframes searched and followed.
struct Done {
  std::size_t before = 0;  // in parts searched already
  std::size_t total = 0;
};

struct FoundGround {
  Ground ground;
  bool is_of_patches = false;  // small ones told it
};

// In keyframes that tracking registered to each other, by pictures turned upright so.
class GroundSearch {
 public:
  GroundSearch(const FrameSource& frames,
               std::vector<TrackedFrame> keyframes,
               QuarterTurn upright,
               const GroundOptions& options,
               const Done& done,
               Progress& progress)
      : frames_(frames),
        upright_(upright),
        options_(options),
        done_(done),
        progress_(progress),
        keyframes_(std::move(keyframes)),
        num_samples_(std::clamp(kAllSamplePoints / std::max<std::size_t>(1, keyframes_.size()),
                                kLeastSamplePoints,
                                kMostSamplePoints)) {}

  Result<FoundGround> Run() {
    if (!FindSightings()) return Interrupted();
    const auto start = FindGroundSighting(sightings_, samples_, options_);
    // What is so near below the camera may be a table top.
    if (!start || sightings_[*start].plane_camera.d_m < kLowCameraM) {
      Result<std::optional<Ground>> found = GroundOfPatches();
      if (!found.ok()) return found.error();
      if (*found) return FoundGround{**std::move(found), true};
    }
    Ground ground;
    if (!start) return FoundGround{};
    observations_.resize(keyframes_.size());
    const PlaneSighting& sighting = sightings_[*start];
    const Plane plane_camera = sighting.plane_camera;
    if (!Propagate(sighting.keyframe, plane_camera, +1) ||
        !Propagate(sighting.keyframe, plane_camera, -1)) {
      return Interrupted();
    }
    for (const auto& observation : observations_) {
      if (observation) ground.observations.push_back(*observation);
    }
    if (!ground.observations.empty()) ground.plane_world = CommonPlane(sighting.plane_world);
    return FoundGround{std::move(ground), false};
  }

 private:
  Result<std::optional<Ground>> GroundOfPatches() const {
    const std::optional<Eigen::Vector3d> up_world = VerticalDirection(sightings_);
    if (!up_world) return std::optional<Ground>();
    const std::optional<std::vector<FloorPatch>> found = FindPatches(*up_world);
    if (!found) return Interrupted();
    const std::vector<FloorPatch>& patches = *found;
    const auto level = FindLowestLevel(patches, samples_, *up_world, options_);
    if (!level) return std::optional<Ground>();
    return std::optional(GroundOf(*level, patches, keyframes_, *up_world));
  }

  // The lowest patch of each keyframe that has one; nothing when interrupted.
  [[nodiscard]] std::optional<std::vector<FloorPatch>> FindPatches(
      const Eigen::Vector3d& up_world) const {
    std::vector<FloorPatch> patches;
    for (std::size_t begin = 0; begin < keyframes_.size(); begin += kBatchKeyframes) {
      if (progress_.StopRequested()) return std::nullopt;
      std::vector<std::optional<FloorPatch>> batch(
          std::min(kBatchKeyframes, keyframes_.size() - begin));
      ParallelFor(batch.size(), [&](std::size_t n) { batch[n] = PatchOf(begin + n, up_world); });
      for (const std::optional<FloorPatch>& patch : batch) {
        if (patch) patches.push_back(*patch);
      }
    }
    return patches;
  }

  [[nodiscard]] std::optional<FloorPatch> PatchOf(std::size_t k,
                                                  const Eigen::Vector3d& up_world) const {
    const Pose3& pose = keyframes_[k].world_from_camera;
    const GroundPoints points = ReadPoints(k);
    std::optional<FloorPatch> patch =
        LowestPatch(points, frames_.camera(), pose.rotation.conjugate() * up_world);
    if (!patch) return patch;
    patch->keyframe = k;
    patch->height_m = up_world.dot(pose.translation_m) - patch->below_camera_m;
    patch->num_points *= points.step_px * points.step_px;
    return patch;
  }

  [[nodiscard]] GroundPoints ReadPoints(std::size_t k) const {
    const Result<Frame> frame = frames_.ReadDepth(keyframes_[k].frame);
    if (!frame.ok()) return {};
    return ExtractGroundPoints(frame->depth_m, frames_.camera(), options_.max_depth_m);
  }

  bool FindSightings() {
    std::vector<std::vector<PlaneSighting>> found(keyframes_.size());
    samples_.resize(keyframes_.size());
    for (std::size_t begin = 0; begin < keyframes_.size(); begin += kBatchKeyframes) {
      if (progress_.StopRequested()) return false;
      const std::size_t count = std::min(kBatchKeyframes, keyframes_.size() - begin);
      ParallelFor(count, [&](std::size_t n) { SearchKeyframe(begin + n, found[begin + n]); });
      progress_.Report(done_.before + begin + count, done_.total);
    }
    for (const auto& planes : found)
      sightings_.insert(sightings_.end(), planes.begin(), planes.end());
    return true;
  }

  void SearchKeyframe(std::size_t k, std::vector<PlaneSighting>& found) {
    const Pose3& world_from_camera = keyframes_[k].world_from_camera;
    const GroundPoints points = ReadPoints(k);
    Random random(0, "ground", static_cast<std::uint64_t>(keyframes_[k].frame.value));
    for (const PlaneCandidate& candidate : FindPlanes(points, upright_, random)) {
      found.push_back({k,
                       candidate.plane_camera,
                       Transformed(world_from_camera, candidate.plane_camera),
                       world_from_camera * candidate.centroid_camera,
                       candidate.plane_camera.d_m,
                       candidate.share});
    }
    const std::size_t step = std::max<std::size_t>(1, points.points.size() / num_samples_);
    samples_[k].points_world.reserve((points.points.size() + step - 1) / step);
    for (std::size_t n = 0; n < points.points.size(); n += step) {
      const Eigen::Vector3d p_world = world_from_camera * points.points[n].p_camera.cast<double>();
      samples_[k].points_world.push_back(p_world.cast<float>());
    }
  }

  // Carries the plane from keyframe to keyframe in one direction, correcting it where the ground is
  // seen.
  bool Propagate(std::size_t start, const Plane& start_camera, int direction) {
    Plane plane = start_camera;
    Eigen::Matrix3d information = InformationOf(2 * kRadPerDeg, 0.05);
    const std::size_t count = direction > 0 ? keyframes_.size() - start : start + 1;
    const auto index = [&](std::size_t n) { return direction > 0 ? start + n : start - n; };
    for (std::size_t begin = 0; begin < count; begin += kBatchKeyframes) {
      if (progress_.StopRequested()) return false;
      std::vector<GroundPoints> batch(std::min(kBatchKeyframes, count - begin));
      ParallelFor(batch.size(), [&](std::size_t n) { batch[n] = ReadPoints(index(begin + n)); });
      for (std::size_t n = 0; n < batch.size(); ++n) {
        const std::size_t k = index(begin + n);
        if (begin + n > 0) {
          const Pose3& from = keyframes_[index(begin + n - 1)].world_from_camera;
          plane = Transformed(keyframes_[k].world_from_camera.Inverse() * from, plane);
          information = WithAddedError(information, kStepAngleRad, kStepDistanceM);
        }
        Observe(k, batch[n], plane, information);
      }
    }
    progress_.Report(done_.before + keyframes_.size() + (direction > 0 ? count : keyframes_.size()),
                     done_.total);
    return true;
  }

  // Refines the propagated plane in keyframe k and joins both by their information.
  void Observe(std::size_t k,
               const GroundPoints& points,
               Plane& plane,
               Eigen::Matrix3d& information) {
    const auto refined = FindAgain(k, points, plane, ReachOf(information));
    if (!refined) return;
    observations_[k] = GroundObservation{keyframes_[k].frame,
                                         refined->plane_camera,
                                         refined->information,
                                         refined->num_inliers * points.step_px * points.step_px};
    const Eigen::Matrix3d joint = information + refined->information;
    const Eigen::Vector3d step =
        joint.ldlt().solve(refined->information * Difference(plane, refined->plane_camera));
    plane = Perturbed(plane, step);
    information = joint;
  }

  // What is seen of the plane near `predicted`, when that is enough for an observation.
  [[nodiscard]] std::optional<PlaneRefinement> SeenNear(const Plane& predicted,
                                                        const GroundPoints& points) const {
    std::optional<PlaneRefinement> refined = RefinePlane(points, frames_.camera(), predicted);
    if (!refined || refined->inlier_share < GroundOptions::kMinInlierShare ||
        refined->area_m2 < GroundOptions::kMinArea_m2) {
      return std::nullopt;
    }
    const double height_m = refined->plane_camera.d_m;
    if (height_m < options_.min_height_m || height_m > options_.max_height_m) return std::nullopt;
    return refined;
  }

  [[nodiscard]] std::optional<PlaneRefinement> FindAgain(std::size_t k,
                                                         const GroundPoints& points,
                                                         const Plane& predicted,
                                                         const Reach& reach) const {
    std::optional<PlaneRefinement> nearest = SeenNear(predicted, points);
    if (!IsWide(reach)) return nearest;
    std::vector<PlaneRefinement> found;
    if (nearest) found.push_back(*nearest);
    for (const Plane& start : PlanesWithin(SightingsOf(k), predicted, reach)) {
      if (const auto refined = SeenNear(start, points)) found.push_back(*refined);
    }
    if (found.empty()) return std::nullopt;
    const double largest = std::ranges::max(found, {}, &PlaneRefinement::inlier_share).inlier_share;
    std::erase_if(found, [&](const PlaneRefinement& plane) {
      return plane.inlier_share < kMinShareOfLargest * largest;
    });
    const PlaneRefinement& lowest = std::ranges::max(
        found, {}, [](const PlaneRefinement& plane) { return plane.plane_camera.d_m; });
    const Plane plane_world = Transformed(keyframes_[k].world_from_camera, lowest.plane_camera);
    if (!IsLowest(plane_world, SamplesAbout(k))) return std::nullopt;
    return lowest;
  }

  [[nodiscard]] std::span<const PlaneSighting> SightingsOf(std::size_t k) const {
    return {std::ranges::lower_bound(sightings_, k, {}, &PlaneSighting::keyframe),
            std::ranges::upper_bound(sightings_, k, {}, &PlaneSighting::keyframe)};
  }

  [[nodiscard]] std::span<const KeyframeSample> SamplesAbout(std::size_t k) const {
    const std::size_t begin = k - std::min(k, kKeyframesAbout);
    const std::size_t end = std::min(k + kKeyframesAbout + 1, samples_.size());
    return std::span(samples_).subspan(begin, end - begin);
  }

  // Gauss-Newton on the plane's three degrees of freedom over all observations, Cauchy weights.
  [[nodiscard]] Plane CommonPlane(const Plane& start_world) const {
    Plane plane = start_world;
    for (int n = 0; n < 15; ++n) {
      const Eigen::Matrix<double, 3, 2> basis_world = GroundTangentBasis(plane.normal);
      Eigen::Matrix3d hessian = Eigen::Matrix3d::Zero();
      Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
      for (std::size_t k = 0; k < observations_.size(); ++k) {
        if (!observations_[k]) continue;
        const Pose3& world_from_camera = keyframes_[k].world_from_camera;
        const Plane& seen = observations_[k]->plane_camera;
        const Plane predicted = Transformed(world_from_camera.Inverse(), plane);
        Eigen::Matrix3d jacobian = Eigen::Matrix3d::Zero();
        jacobian.topLeftCorner<2, 2>() = GroundTangentBasis(seen.normal).transpose() *
                                         world_from_camera.rotation.toRotationMatrix().transpose() *
                                         basis_world;
        jacobian.bottomLeftCorner<1, 2>() =
            world_from_camera.translation_m.transpose() * basis_world;
        jacobian(2, 2) = 1;
        const Eigen::Vector3d error = Difference(seen, predicted);
        const Eigen::Matrix3d information =
            WithAddedError(observations_[k]->information, kDriftAngleRad, kDriftDistanceM);
        const double weight = 1 / (1 + error.dot(information * error) / 3);
        hessian += weight * jacobian.transpose() * information * jacobian;
        gradient += weight * jacobian.transpose() * information * error;
      }
      plane = Perturbed(plane, -hessian.ldlt().solve(gradient));
    }
    return plane;
  }

  const FrameSource& frames_;
  const QuarterTurn upright_;
  const GroundOptions& options_;
  Done done_;
  Progress& progress_;
  std::vector<TrackedFrame> keyframes_;
  const std::size_t num_samples_;  // of a keyframe
  std::vector<PlaneSighting> sightings_;
  std::vector<KeyframeSample> samples_;
  std::vector<std::optional<GroundObservation>> observations_;
};

using Part = std::vector<TrackedFrame>;  // keyframes that tracking registered to each other

std::vector<Part> PartsOf(const Odometry& odometry,
                          std::span<const MeasuredSubTrajectory> sub_trajectories) {
  std::vector<Part> parts;
  for (const MeasuredSubTrajectory& sub_trajectory : sub_trajectories) {
    const auto part = static_cast<std::size_t>(sub_trajectory.part);
    if (part == parts.size()) parts.emplace_back();
    for (int k = sub_trajectory.first_keyframe; k < sub_trajectory.end_keyframe; ++k) {
      const TrackedFrame& frame = odometry.at(odometry.keyframes[static_cast<std::size_t>(k)]);
      if (HasPose(frame)) parts[part].push_back(frame);
    }
  }
  return parts;
}

// The sub-trajectories that are not of the first keyframe's part, each with its part's plane.
std::vector<GroundApart> Apart(const Odometry& odometry,
                               std::span<const MeasuredSubTrajectory> sub_trajectories,
                               std::span<const std::optional<Plane>> planes_world) {
  const auto frame = [&](int keyframe) {
    return odometry.keyframes[static_cast<std::size_t>(keyframe)];
  };
  const FrameIdx end{static_cast<int>(odometry.frames.size())};
  std::vector<GroundApart> apart;
  for (std::size_t n = 0; n < sub_trajectories.size(); ++n) {
    if (sub_trajectories[n].part == 0) continue;
    const bool last = n + 1 == sub_trajectories.size();
    apart.push_back({frame(sub_trajectories[n].first_keyframe),
                     last ? end : frame(sub_trajectories[n + 1].first_keyframe),
                     planes_world[static_cast<std::size_t>(sub_trajectories[n].part)]});
  }
  return apart;
}

// The turn that the user gives; nothing where the ground is to tell it.
std::optional<QuarterTurn> GivenTurn(const GroundOptions& options) {
  const auto at = std::ranges::find(kTurnsDeg, options.upright_deg);
  if (at == kTurnsDeg.begin() || at == kTurnsDeg.end()) return std::nullopt;
  return kTurns[static_cast<std::size_t>(at - kTurnsDeg.begin() - 1)];
}

// Of one part: with pictures turned by `habit`, and where that does not convince, as what they show
// asks for; `habit` is what it was in the end.
Result<FoundGround> SearchPart(const FrameSource& frames,
                               const Part& part,
                               const GroundOptions& options,
                               const Done& done,
                               Progress& progress,
                               QuarterTurn& habit) {
  const auto search = [&](QuarterTurn upright) {
    return GroundSearch(frames, part, upright, options, done, progress).Run();
  };
  const QuarterTurn as_is = habit;
  Result<FoundGround> found = search(as_is);
  if (!found.ok() || GivenTurn(options)) return found;
  const Holding before = MeasureHolding(found->ground, part, as_is);
  if (Convinces(before)) return found;
  if (!IsPossible(before)) found = FoundGround{};
  double most = 0;
  for (const QuarterTurn upright : kTurns) {
    if (upright == as_is) continue;
    Result<FoundGround> turned = search(upright);
    if (!turned.ok()) return turned;
    const Holding holding = MeasureHolding(turned->ground, part, upright);
    if (!Outweighs(holding, upright, before) || Evidence(holding) <= most) continue;
    most = Evidence(holding);
    habit = upright;
    found = std::move(turned);
  }
  return found;
}

void WarnOfPatches(const Ground& ground, Progress& progress) {
  progress.Warn(
      fmt::format("little floor is in view: {} keyframes with small patches of it tell the ground. "
                  "Where things "
                  "stand too high or too low, name it: `ground` in overrides.yaml",
                  ground.observations.size()));
}

// What looks like the floor may be a table top where the floor never came into view.
void WarnOfLowCamera(const Ground& ground, Progress& progress) {
  if (ground.observations.empty()) return;
  std::vector<double> heights_m;
  for (const GroundObservation& seen : ground.observations)
    heights_m.push_back(seen.plane_camera.d_m);
  const double height_m = Median(heights_m);
  if (height_m >= kLowCameraM) return;
  progress.Warn(fmt::format(
      "the lowest level in view is only {:.2f} m below the camera: a floor below a robot, but a "
      "table top below a camera held in a hand. If the floor was never in view, name it: `ground` "
      "in overrides.yaml",
      height_m));
}

}  // namespace

Result<Ground> EstimateGround(const FrameSource& frames,
                              const Odometry& odometry,
                              const GroundOptions& options,
                              Progress& progress) {
  const auto sub_trajectories =
      MeasuredSubTrajectories(odometry.frames, odometry.keyframes, JoinsOf(odometry));
  const std::vector<Part> parts = PartsOf(odometry, sub_trajectories);
  Done done;
  for (const Part& part : parts) done.total += 2 * part.size();
  Ground ground;
  ground.upright = GivenTurn(options);
  std::vector<std::optional<Plane>> planes_world;
  QuarterTurn upright = ground.upright.value_or(QuarterTurn::kNone);
  for (const Part& part : parts) {
    Result<FoundGround> found = SearchPart(frames, part, options, done, progress, upright);
    if (!found.ok()) return found.error();
    if (found->is_of_patches) WarnOfPatches(found->ground, progress);
    const Ground& own = found->ground;
    done.before += 2 * part.size();
    planes_world.push_back(own.plane_world);
    ground.observations.insert(
        ground.observations.end(), own.observations.begin(), own.observations.end());
  }
  std::ranges::sort(ground.observations, {}, &GroundObservation::keyframe);
  if (!planes_world.empty()) ground.plane_world = planes_world.front();
  ground.apart = Apart(odometry, sub_trajectories, planes_world);
  WarnOfLowCamera(ground, progress);
  return ground;
}

void Describe(OptionsVisitor& visitor, GroundOptions& options) {
  visitor.Choice("upright_deg",
                 options.upright_deg,
                 kTurnsDeg,
                 "clockwise turn that sets the pictures upright; auto: as the ground asks for");
  visitor.Field(
      "min_height_m", options.min_height_m, {0, 100}, "m", "lowest camera above the ground");
  visitor.Field(
      "max_height_m", options.max_height_m, {0, 100}, "m", "highest camera above the ground");
  visitor.Field("max_depth_m", options.max_depth_m, {0.1, 100}, "m", "farther points are left out");
}

}  // namespace deepslam::ground
