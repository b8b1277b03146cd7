// A world of cuboids as its fused surface, and what is found in it.
#pragma once

#include <algorithm>
#include <iterator>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "deepslam/instances/find_instances.h"
#include "support/box_world.h"

namespace deepslam::instances {

using namespace testing_support;  // NOLINT

inline constexpr double kVoxelM = 0.04;
inline constexpr double kSampleM = 0.02;

// Surface of a world of cuboids as a fused capture has it, with the cuboid's object.
struct SampledWorld {
  std::vector<Eigen::Vector3f> points;
  std::vector<Eigen::Vector3f> normals;
};

inline bool IsInside(const std::vector<Cuboid>& world, const Eigen::Vector3d& point) {
  return std::ranges::any_of(world, [&](const Cuboid& box) {
    return (point.array() > box.min_m.array() + 1e-6).all() &&
           (point.array() < box.max_m.array() - 1e-6).all();
  });
}

inline void SampleSide(const std::vector<Cuboid>& world,
                       const Cuboid& box,
                       int axis,
                       double sign,
                       SampledWorld& sampled) {
  const int a = (axis + 1) % 3;
  const int b = (axis + 2) % 3;
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  normal[axis] = sign;
  for (double s = box.min_m[a] + kSampleM / 2; s < box.max_m[a]; s += kSampleM) {
    for (double t = box.min_m[b] + kSampleM / 2; t < box.max_m[b]; t += kSampleM) {
      Eigen::Vector3d p;
      p[axis] = sign > 0 ? box.max_m[axis] : box.min_m[axis];
      p[a] = s;
      p[b] = t;
      // Sides on the floor, and sides that other things cover, nobody sees.
      if (p.z() < 1e-3 || IsInside(world, p + 1e-3 * normal)) continue;
      sampled.points.push_back(p.cast<float>());
      sampled.normals.push_back(normal.cast<float>());
    }
  }
}

inline SampledWorld Sample(const std::vector<Cuboid>& world) {
  SampledWorld sampled;
  for (const Cuboid& box : world) {
    for (int axis = 0; axis < 3; ++axis) {
      SampleSide(world, box, axis, 1, sampled);
      SampleSide(world, box, axis, -1, sampled);
    }
  }
  return sampled;
}

inline ClassTable Classes() {
  ClassTable table;
  table.classes = {{"chair", {"chair"}, {}, 0.4, 1.5, 0.4, 1.4, {}, {}},
                   {"table", {"dining table"}, {}, 0.4, 4, 0.3, 1.2, {}, {}},
                   {"bed", {"bed"}, {}, 1.2, 2.7, 0.25, 2, {}, {}},
                   {"cabinet", {}, {}, 0.3, 2.6, 0.3, 2.5, {}, {}},
                   {"furniture", {}, {}, 0.2, 3.5, 0.15, 2.7, {}, {.fallback = true}}};
  return table;
}

struct Label {
  int object;
  std::string class_name;
};

enum class Evidence { kNone, kBoxes, kMasks };

// True detections of the objects that have a label, as a network would give them.
inline std::vector<Detection> Detect(const BoxView& view,
                                     const std::vector<Label>& labels,
                                     Evidence evidence) {
  std::vector<Detection> detections;
  for (const Label& label : labels) {
    std::optional<Detection> detection = DetectTruth(view, label.object, label.class_name);
    if (!detection || evidence == Evidence::kNone) continue;
    if (evidence == Evidence::kMasks) {
      Mask mask(view.object.width(), view.object.height());
      for (std::size_t p = 0; p < mask.size(); ++p)
        mask.data()[p] = view.object.data()[p] == label.object ? 1 : 0;
      detection->mask = mask;
    }
    detections.push_back(*std::move(detection));
  }
  return detections;
}

struct Found {
  SurfaceElements elements{{}, {}, kVoxelM};
  Instances instances;
};

inline VotingView ViewOf(const BoxView& view,
                         const Pose3& pose,
                         std::span<const Detection> detections) {
  return {&view.frame.depth_m, SmallCamera(), pose.Inverse(), detections};
}

inline Found Find(const std::vector<Cuboid>& world,
                  const std::vector<Pose3>& poses,
                  const std::vector<Label>& labels,
                  Evidence evidence,
                  const InstanceOptions& options = {},
                  const ClassTable& classes = Classes()) {
  const SampledWorld sampled = Sample(world);
  Found found{SurfaceElements(sampled.points, sampled.normals, kVoxelM), {}};
  const std::vector<char> is_structure(found.elements.size(), 0);
  const std::vector<ElementPair> pairs = found.elements.PairsWithin(1.9 * kVoxelM);
  const Superpoints superpoints =
      MakeSuperpoints(found.elements, is_structure, pairs, options.superpoints);
  ViewVotes votes;
  for (const Pose3& pose : poses) {
    const BoxView view = RenderBoxes(world, SmallCamera(), pose);
    const std::vector<Detection> detections = Detect(view, labels, evidence);
    const VisibleElements visible =
        FindVisible(found.elements, ViewOf(view, pose, detections), options.votes);
    AddVotes(ClaimSuperpoints(superpoints, visible, detections, options.votes),
             detections,
             superpoints.count(),
             votes);
  }
  found.instances = FindInstances(found.elements, superpoints, pairs, votes, {}, classes, options);
  return found;
}

inline std::vector<Instance> Mapped(const Found& found) {
  std::vector<Instance> mapped;
  std::ranges::copy_if(found.instances.instances,
                       std::back_inserter(mapped),
                       [](const Instance& i) { return i.rejection.empty(); });
  return mapped;
}

inline int CountClass(const std::vector<Instance>& instances, const std::string& name) {
  return static_cast<int>(std::ranges::count(instances, name, &Instance::class_name));
}

}  // namespace deepslam::instances
