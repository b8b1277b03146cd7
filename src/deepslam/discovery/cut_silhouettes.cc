#include "deepslam/discovery/cut_silhouettes.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>

#include <Eigen/Core>

#include "deepslam/geometry/level_rectangle.h"
#include "deepslam/geometry/pixel_box.h"
#include "deepslam/geometry/plane.h"

namespace deepslam::discovery {
namespace {

using instances::Instance;
using instances::Silhouette;

// A thing goes on this far beyond what the surface of the capture holds of it.
constexpr double kBeyondSurfaceM = 0.08;
constexpr double kAboveTopM = 0.015;  // above its height a top is the top: errors of the path
// ... and three deviations of a Kinect's noise seen at 30 degrees, per squared metre of depth.
constexpr double kAboveTopPerM2 = 0.0025;

const Instance& ThingOf(const FrameOfThings& seen, const Silhouette& silhouette) {
  return seen.things[static_cast<std::size_t>(silhouette.instance)];
}

// 1 + the silhouette of each pixel; 0: none.
Image<int> Owners(const DepthImage& depth_m, std::span<const Silhouette> silhouettes) {
  Image<int> owners(depth_m.width(), depth_m.height(), 0);
  for (std::size_t n = 0; n < silhouettes.size(); ++n) {
    for (int v = 0; v < owners.height(); ++v) {
      for (int u = 0; u < owners.width(); ++u) {
        if (silhouettes[n].mask(u, v) != 0) owners(u, v) = static_cast<int>(n) + 1;
      }
    }
  }
  return owners;
}

// What may be of the n-th silhouette's thing: within its outline on the floor and of no other
// thing.
Detection AsDetection(const FrameOfThings& seen,
                      const Instance& thing,
                      const Image<int>& owners,
                      std::size_t n) {
  const DepthImage& depth_m = seen.frame.depth_m;
  const instances::UprightBox& box = thing.box_level;
  const LevelRectangle outline{box.centre_m,
                               box.yaw_rad,
                               box.length_m + 2 * kBeyondSurfaceM,
                               box.width_m + 2 * kBeyondSurfaceM};
  const int own = static_cast<int>(n) + 1;
  Detection detection;
  detection.class_name = thing.class_name;
  detection.source = DetectionSource::kCluster;  // it is depth, and no wall
  Mask mask(depth_m.width(), depth_m.height());
  for (int v = 0; v < depth_m.height(); ++v) {
    for (int u = 0; u < depth_m.width(); ++u) {
      const double z_m = depth_m(u, v);
      if (!(z_m > 0) || (owners(u, v) != 0 && owners(u, v) != own)) continue;
      const Eigen::Vector3d p_level = seen.level_from_camera * seen.camera.Unproject(u, v, z_m);
      if (p_level.z() > box.top_m + kBeyondSurfaceM || !outline.Contains(p_level.head<2>()))
        continue;
      mask(u, v) = 1;
      ExtendByPixel(u, v, detection.box_px);
    }
  }
  detection.mask = mask;
  return detection;
}

// Without what was measured above the thing's top: of what stands on it or before it.
Silhouette UpToTop(const FrameOfThings& seen, double top_m, Silhouette silhouette) {
  const DepthImage& depth_m = seen.frame.depth_m;
  for (int v = 0; v < depth_m.height(); ++v) {
    for (int u = 0; u < depth_m.width(); ++u) {
      const double z_m = depth_m(u, v);
      if (silhouette.mask(u, v) == 0 || !(z_m > 0)) continue;
      const Eigen::Vector3d p_level = seen.level_from_camera * seen.camera.Unproject(u, v, z_m);
      if (p_level.z() > top_m + kAboveTopM + kAboveTopPerM2 * z_m * z_m) silhouette.mask(u, v) = 0;
    }
  }
  instances::FitToMask(depth_m, seen.camera, silhouette);
  return silhouette;
}

// The silhouette as the segment has it. Pixels of other things, which widened masks may reach, stay
// theirs. `own`: its number among the owners.
Silhouette CutBy(const FrameOfThings& seen,
                 const Segment& segment,
                 const Image<int>& owners,
                 int own,
                 Silhouette silhouette) {
  silhouette.mask = segment.mask.Unpacked();
  for (std::size_t pixel = 0; pixel < owners.size(); ++pixel) {
    const int owner = owners.data()[pixel];
    if (owner != 0 && owner != own) silhouette.mask.data()[pixel] = 0;
  }
  instances::FitToMask(seen.frame.depth_m, seen.camera, silhouette);
  return silhouette;
}

void Mark(const Mask& mask, int own, Image<int>& owners) {
  for (std::size_t pixel = 0; pixel < owners.size(); ++pixel) {
    if (mask.data()[pixel] != 0) owners.data()[pixel] = own;
  }
}

}  // namespace

void CutSilhouettes(const FrameOfThings& seen,
                    const ClassTable& classes,
                    const segment::SegmentOptions& options,
                    std::vector<Silhouette>& silhouettes) {
  if (std::ranges::none_of(silhouettes, [&](const Silhouette& silhouette) {
        return ThingOf(seen, silhouette).has_support_plane;
      }))
    return;
  Image<int> owners = Owners(seen.frame.depth_m, silhouettes);
  std::vector<Detection> detections;
  std::vector<std::size_t> silhouette_of;
  for (std::size_t n = 0; n < silhouettes.size(); ++n) {
    const Instance& thing = ThingOf(seen, silhouettes[n]);
    if (!thing.has_support_plane) continue;
    detections.push_back(AsDetection(seen, thing, owners, n));
    silhouette_of.push_back(n);
  }
  const Plane ground_camera =
      Transformed(seen.level_from_camera.Inverse(), Plane{Eigen::Vector3d::UnitZ(), 0});
  const std::vector<Segment> segments =
      segment::SegmentFrame({seen.frame, seen.camera, ground_camera, detections}, classes, options);
  for (std::size_t k = 0; k < segments.size(); ++k) {
    if (!segments[k].usable) continue;
    const std::size_t n = silhouette_of[k];
    const int own = static_cast<int>(n) + 1;
    Silhouette cut = CutBy(seen, segments[k], owners, own, silhouettes[n]);
    if (cut.num_points < options.min_points) continue;  // all but a rest is of other things
    Mark(cut.mask, own, owners);
    silhouettes[n] = std::move(cut);
  }
  for (const std::size_t n : silhouette_of) {
    const std::optional<double> top_m = ThingOf(seen, silhouettes[n]).top_m;
    if (!top_m) continue;
    Silhouette cut = UpToTop(seen, *top_m, silhouettes[n]);
    if (cut.num_points >= options.min_points) silhouettes[n] = std::move(cut);
  }
}

}  // namespace deepslam::discovery
