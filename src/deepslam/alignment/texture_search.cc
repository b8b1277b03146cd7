#include "deepslam/alignment/weak_direction_search.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "deepslam/alignment/gauss_newton.h"
#include "deepslam/frames/texture_match.h"

namespace deepslam::alignment {
namespace {

// Depth leaves no more directions free: a plane does three.
constexpr std::size_t kMostDirections = 3;
using Offsets = std::array<double, kMostDirections>;  // in steps

// Places are looked at to this many deviations of the start, and no further than so many steps.
constexpr double kReachSigmas = 3;
constexpr int kMostSteps = 12;     // a third of the image to both sides; 15,000 places
constexpr int kMostNearSteps = 4;  // 6 cm at a wall one metre off
// Every third row and column counts: at the coarsest level that is as far as errors of intensity
// are shared (AlignmentOptions::photometric_correlation_length_px).
constexpr int kStride = 3;
// Of the best place's information; chance leaves less.
constexpr double kRivalShare = 0.5;
// The peak at a place is no wider than this, in steps.
constexpr double kPeakSteps = 3;
// The end of iterations that is nearer, in pixels of the coarsest level, is the place.
constexpr double kSameEndPx = 0.5;
// Where images move by less, pixels of the coarsest level, what they have in common may be the
// camera's own: blocks of JPEG files along shading that moves with the lens, dirt.
constexpr double kStillPx = 0.25;
// Of JPEG files. Pixels of levels that texture is looked for at are means of as many of the
// capture's, since finer ones show the file.
constexpr int kBlockPx = 8;
constexpr int kRounds = 2;  // over all directions, at each level
// Deviation of a place that texture shows, pixels of the finest level.
constexpr double kPlaceSigmaPx = 0.5;
constexpr double kProbeM = 1e-3;  // of a direction, to see how far images move
// Places between pixels lose more than a tenth of their correlation by interpolation.
constexpr double kInterpolatedCorrelation = 0.9;
// Of the image's patches, to be sure that all of it is there: who walks by takes a part along.
constexpr double kMinAlike = 0.9;

// Places that differ from a centre along some directions.
struct Places {
  Pose3 centre;
  std::vector<Vector6d> steps;  // perturbations that move the image by a pixel (rms)

  [[nodiscard]] Pose3 At(const Offsets& offsets) const {
    Vector6d motion = Vector6d::Zero();
    for (std::size_t k = 0; k < steps.size(); ++k) motion += offsets[k] * steps[k];
    return V2t(motion) * centre;
  }
};

Places PlacesAround(const Pose3& centre,
                    const std::vector<Vector6d>& directions,
                    const TextureMatch& level) {
  Places places{centre, {}};
  for (const Vector6d& direction : directions) {
    const double moved_px = level.DistancePx(V2t(kProbeM * direction) * centre, centre);
    places.steps.push_back(kProbeM / std::max(moved_px, kProbeM) * direction);
  }
  return places;
}

// Of a motion from the start.
double SigmasOf(const Vector6d& motion, const StartSigma& sigma) {
  return std::hypot(
      motion.head<3>().norm() / std::hypot(sigma.translation_m, kPredictionSigma.translation_m),
      motion.tail<3>().norm() / std::hypot(sigma.rotation_rad, kPredictionSigma.rotation_rad));
}

// Offsets to both sides of the centre, within what the start leaves open.
std::vector<Offsets> OffsetsWithin(const Places& places, const FirstStart& start) {
  std::vector<Offsets> grid = {Offsets{}};
  for (std::size_t k = 0; k < places.steps.size(); ++k) {
    const double steps = std::ceil(kReachSigmas / SigmasOf(places.steps[k], start.sigma));
    const int most = start.is_near ? kMostNearSteps : kMostSteps;
    const int reach = std::clamp(static_cast<int>(std::min(steps, 1e3)), 1, most);
    std::vector<Offsets> wider;
    for (const Offsets& offsets : grid) {
      for (int n = -reach; n <= reach; ++n) {
        wider.push_back(offsets);
        wider.back()[k] = n;
      }
    }
    grid = std::move(wider);
  }
  return grid;
}

bool IsSamePeak(const Offsets& a, const Offsets& b) {
  for (std::size_t k = 0; k < a.size(); ++k)
    if (std::abs(a[k] - b[k]) > kPeakSteps) return false;
  return true;
}

class TextureSearch {
 public:
  TextureSearch(const FramePyramid& i,
                const FramePyramid& j,
                std::vector<Vector6d> directions,
                const AlignmentOptions& options)
      : i_(i), j_(j), directions_(std::move(directions)), options_(options) {}

  std::optional<TexturePlace> Run(const Pose3& centre, const FirstStart& start, const Pose3& end) {
    const TextureMatch level = MatchAt(Coarsest());
    const Places places = PlacesAround(centre, directions_, level);
    const std::vector<Offsets> grid = OffsetsWithin(places, start);
    // As many at all places: how many there are is least where the camera moved most.
    const double num =
        level.Compare(centre).num_points /
        PixelsPerMeasurement(
            i_.levels[Coarsest()], kStride, options_.photometric_correlation_length_px);
    // The best of so many places shares the logarithm of their number by chance.
    const double sure = kSureNats + std::log(static_cast<double>(grid.size()));
    const std::optional<Pose3> best = BestOf(grid, places, level, num, sure);
    if (!best) return std::nullopt;
    if (level.DistancePx(*best, end) > kPeakSteps &&
        IsRival(Information(level, num, end), Information(level, num, *best)))
      return std::nullopt;
    return Concluded(level, *best, end);
  }

 private:
  [[nodiscard]] std::size_t Coarsest() const { return NumAlignmentLevels(i_) - 1; }

  [[nodiscard]] TextureMatch MatchAt(std::size_t n) const {
    const PyramidLevel &i = i_.levels[n], &j = j_.levels[n];
    return {{i.camera, i.intensity}, {j.camera, j.intensity}, j.depth_m, kStride};
  }

  // Nats that so many measurements of both textures share at a place: that of jointly normal
  // variables.
  static double Information(const TextureMatch& level, double num, const Pose3& i_from_j) {
    const double correlation =
        std::clamp(level.Compare(i_from_j).correlation, 0.0, kInterpolatedCorrelation);
    return -0.5 * num * std::log(1 - correlation * correlation);
  }

  // An edge alone is like itself all along it, and the best place is it and its surroundings.
  static bool IsRival(double information, double best) {
    return information > std::min(best - kSureNats, kRivalShare * best);
  }

  // Nothing where none is sure, or another is half as good: stripes, tiles.
  static std::optional<Pose3> BestOf(const std::vector<Offsets>& grid,
                                     const Places& places,
                                     const TextureMatch& level,
                                     double num,
                                     double sure) {
    std::vector<double> information;
    for (const Offsets& offsets : grid)
      information.push_back(Information(level, num, places.At(offsets)));
    const auto best =
        static_cast<std::size_t>(std::ranges::max_element(information) - information.begin());
    if (information[best] < sure) return std::nullopt;
    for (std::size_t k = 0; k < grid.size(); ++k)
      if (IsRival(information[k], information[best]) && !IsSamePeak(grid[k], grid[best]))
        return std::nullopt;
    return places.At(grid[best]);
  }

  // The peak about a place: by its height and those a step to both sides along each direction.
  [[nodiscard]] Pose3 PeakAbout(const Pose3& place, const TextureMatch& level) const {
    Pose3 peak = place;
    for (int round = 0; round < kRounds; ++round) {
      const Places places = PlacesAround(peak, directions_, level);
      Offsets offsets{};
      for (std::size_t k = 0; k < places.steps.size(); ++k) {
        const auto height = [&](double n) {
          Offsets at = offsets;
          at[k] = n;
          return level.Compare(places.At(at)).correlation;
        };
        const double before = height(-1), here = height(0), behind = height(1);
        const double bend = before - 2 * here + behind;
        if (here >= std::max(before, behind) && bend < 0)
          offsets[k] = 0.5 * (before - behind) / bend;
        else
          offsets[k] = before > behind ? -1 : 1;
      }
      peak = places.At(offsets);
    }
    return peak;
  }

  [[nodiscard]] std::optional<TexturePlace> Concluded(const TextureMatch& coarsest,
                                                      const Pose3& found,
                                                      const Pose3& end) const {
    TexturePlace place;
    place.i_from_j = PeakAbout(found, coarsest);
    if (coarsest.ShareOfPatches(place.i_from_j) < kMinAlike) return std::nullopt;
    for (std::size_t n = Coarsest(); n-- > 0;) {
      const TextureMatch level = MatchAt(n);
      place.i_from_j = PeakAbout(place.i_from_j, level);
      if (n == 0) place.sigma = SigmaAt(level);
    }
    place.is_end = coarsest.DistancePx(place.i_from_j, end) < kSameEndPx;
    if (place.is_end) place.i_from_j = end;
    if (!place.is_end && coarsest.DistancePx(place.i_from_j, Pose3()) < kStillPx)
      return std::nullopt;
    return place;
  }

  // What a pixel is at the depth, and on the circle about the middle that pixels turn on.
  [[nodiscard]] static StartSigma SigmaAt(const TextureMatch& level) {
    const double sigma_rad = kPlaceSigmaPx / level.camera().fx;
    return {sigma_rad * level.mean_depth_m(), sigma_rad / level.rms_tangent()};
  }

  const FramePyramid& i_;
  const FramePyramid& j_;
  const std::vector<Vector6d> directions_;
  const AlignmentOptions& options_;
};

bool ShowsTexture(const FramePyramid& pyramid) {
  if (pyramid.empty() || pyramid.levels.front().intensity.empty()) return false;
  return pyramid.reduction << (NumAlignmentLevels(pyramid) - 1) >= kBlockPx;
}

}  // namespace

std::optional<TexturePlace> SearchTexture(const FramePyramid& i,
                                          const FramePyramid& j,
                                          const DegenerateDirections& unseen,
                                          const FirstStart& start,
                                          const Pose3& end,
                                          const AlignmentOptions& options) {
  const std::vector<Vector6d> directions = unseen.Directions();
  if (directions.empty() || directions.size() > kMostDirections) return std::nullopt;
  if (!options.photometric || !ShowsTexture(i) || !ShowsTexture(j)) return std::nullopt;
  const Vector6d moved = T2v(end * start.i_from_j.Inverse());
  const Pose3 centre = V2t(moved - unseen.Component(moved)) * start.i_from_j;
  return TextureSearch(i, j, directions, options).Run(centre, start, end);
}

}  // namespace deepslam::alignment
