#include "deepslam/mesh/colour_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "deepslam/core/angles.h"
#include "deepslam/core/parallel.h"

namespace deepslam::mesh {
namespace {

// How far a seen colour spreads over unseen neighbours, in edges.
constexpr int kSpreadRounds = 6;

struct Sample {
  Rgb8 colour;
  double weight = 0;
};

std::vector<Eigen::Vector3d> VertexNormals(const TriangleMesh& mesh) {
  std::vector<Eigen::Vector3d> normals(mesh.vertices.size(), Eigen::Vector3d::Zero());
  for (const auto& face : mesh.faces) {
    const Eigen::Vector3d a = mesh.vertices[face[0]].cast<double>();
    const Eigen::Vector3d b = mesh.vertices[face[1]].cast<double>();
    const Eigen::Vector3d c = mesh.vertices[face[2]].cast<double>();
    const Eigen::Vector3d doubled_area = (b - a).cross(c - a);
    for (const std::uint32_t v : face) normals[v] += doubled_area;
  }
  for (Eigen::Vector3d& n : normals) {
    if (n.norm() > 0) n.normalize();
  }
  return normals;
}

bool IsUsable(const ObjectView& view) {
  const DepthImage& depth = view.depth_crop_m;
  const auto same = [&](int width, int height) {
    return width == depth.width() && height == depth.height();
  };
  return !depth.empty() && same(view.colour_crop.width(), view.colour_crop.height()) &&
         (view.mask_crop.empty() || same(view.mask_crop.width(), view.mask_crop.height())) &&
         view.camera.fx > 0 && view.camera.fy > 0 && view.world_from_camera.Matrix().allFinite();
}

// Near a depth step the colour of a pixel may be that of what lies behind: the images are never
// aligned to the pixel.
bool NextToStep(const DepthImage& depth, int u, int v, double max_step_m) {
  for (const auto& [du, dv] : {std::pair{-1, 0}, {1, 0}, {0, -1}, {0, 1}}) {
    if (!depth.Contains(u + du, v + dv)) return true;
    const float neighbour = depth(u + du, v + dv);
    if (neighbour > 0 && std::abs(neighbour - depth(u, v)) > max_step_m) return true;
  }
  return false;
}

std::optional<Sample> SampleView(const ObjectView& view,
                                 const Eigen::Vector3d& p_camera,
                                 const Eigen::Vector3d& n_camera,
                                 const ColourOptions& options) {
  const double distance = p_camera.norm();
  const std::optional<Eigen::Vector2d> pixel = view.camera.Project(p_camera);
  if (!pixel || !pixel->allFinite() || pixel->cwiseAbs().maxCoeff() > 1e6) return std::nullopt;
  const double cosine = -n_camera.dot(p_camera) / distance;
  if (cosine < std::cos(ColourOptions::kMaxViewAngle_deg * kRadPerDeg)) return std::nullopt;
  const int u = static_cast<int>(std::lround(pixel->x()));
  const int v = static_cast<int>(std::lround(pixel->y()));
  if (!view.depth_crop_m.Contains(u, v)) return std::nullopt;
  const double measured_m = static_cast<double>(view.depth_crop_m(u, v));
  if (!(measured_m > 0) || std::abs(measured_m - p_camera.z()) > ColourOptions::kDepthTolerance_m) {
    return std::nullopt;
  }
  if (options.segment_only && !view.mask_crop.empty() && view.mask_crop(u, v) == 0) {
    return std::nullopt;
  }
  if (NextToStep(view.depth_crop_m, u, v, ColourOptions::kMaxEdgeStep_m)) return std::nullopt;
  return Sample{view.colour_crop(u, v), cosine / (distance * distance)};
}

std::uint8_t WeightedMedian(std::vector<std::pair<std::uint8_t, double>>& values) {
  std::sort(values.begin(), values.end());
  double total = 0;
  for (const auto& [value, weight] : values) total += weight;
  double sum = 0;
  for (const auto& [value, weight] : values) {
    sum += weight;
    if (sum >= 0.5 * total) return value;
  }
  return values.back().first;
}

Rgb8 MedianColour(const std::vector<Sample>& samples) {
  std::array<std::vector<std::pair<std::uint8_t, double>>, 3> channels;
  for (const Sample& sample : samples) {
    channels[0].emplace_back(sample.colour.r, sample.weight);
    channels[1].emplace_back(sample.colour.g, sample.weight);
    channels[2].emplace_back(sample.colour.b, sample.weight);
  }
  return {WeightedMedian(channels[0]), WeightedMedian(channels[1]), WeightedMedian(channels[2])};
}

using Colours = std::vector<std::optional<Rgb8>>;

// One ring further: every colourless vertex takes the mean of its coloured neighbours.
Colours SpreadOnce(const TriangleMesh& mesh, const Colours& colours) {
  std::vector<Eigen::Vector3d> sums(colours.size(), Eigen::Vector3d::Zero());
  std::vector<int> counts(colours.size(), 0);
  for (const auto& face : mesh.faces) {
    for (std::size_t n = 0; n < 3; ++n) {
      for (const std::uint32_t other : {face[(n + 1) % 3], face[(n + 2) % 3]}) {
        if (colours[face[n]] || !colours[other]) continue;
        sums[face[n]] += Eigen::Vector3d(colours[other]->r, colours[other]->g, colours[other]->b);
        ++counts[face[n]];
      }
    }
  }
  Colours result = colours;
  for (std::size_t v = 0; v < colours.size(); ++v) {
    if (counts[v] == 0) continue;
    const Eigen::Vector3d mean = sums[v] / counts[v];
    result[v] = Rgb8{static_cast<std::uint8_t>(std::lround(mean.x())),
                     static_cast<std::uint8_t>(std::lround(mean.y())),
                     static_cast<std::uint8_t>(std::lround(mean.z()))};
  }
  return result;
}

Colours SeenColours(const TriangleMesh& mesh,
                    std::span<const ObjectView> views,
                    const Pose3& world_from_object,
                    const ColourOptions& options) {
  const std::vector<Eigen::Vector3d> normals = VertexNormals(mesh);
  std::vector<std::pair<const ObjectView*, Pose3>> usable;
  for (const ObjectView& view : views) {
    if (IsUsable(view)) {
      usable.emplace_back(&view, view.world_from_camera.Inverse() * world_from_object);
    }
  }
  Colours colours(mesh.vertices.size());
  // Vertices a thread takes at a time; the result does not depend on it.
  constexpr std::size_t kVerticesPerChunk = 256;
  ParallelForChunks(colours.size(), kVerticesPerChunk, [&](std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v < end; ++v) {
      std::vector<Sample> samples;
      for (const auto& [view, camera_from_object] : usable) {
        const std::optional<Sample> sample =
            SampleView(*view,
                       camera_from_object * mesh.vertices[v].cast<double>(),
                       camera_from_object.rotation * normals[v],
                       options);
        if (sample) samples.push_back(*sample);
      }
      if (!samples.empty()) colours[v] = MedianColour(samples);
    }
  });
  return colours;
}

}  // namespace

TriangleMesh ColourMesh(const TriangleMesh& mesh_object_m,
                        std::span<const ObjectView> views,
                        const Pose3& world_from_object,
                        Rgb8 fallback,
                        const ColourOptions& options,
                        ColourReport* report) {
  Colours colours = SeenColours(mesh_object_m, views, world_from_object, options);
  ColourReport counts;
  std::vector<Sample> seen;
  for (const std::optional<Rgb8>& colour : colours) {
    if (colour) seen.push_back({*colour, 1.0});
  }
  counts.num_seen = static_cast<int>(seen.size());
  const Rgb8 rest = seen.empty() ? fallback : MedianColour(seen);
  for (int round = 0; round < kSpreadRounds; ++round) colours = SpreadOnce(mesh_object_m, colours);
  TriangleMesh result = mesh_object_m;
  result.colours.clear();
  for (const std::optional<Rgb8>& colour : colours) {
    result.colours.push_back(colour.value_or(rest));
    if (colour) ++counts.num_spread;
  }
  counts.num_spread -= counts.num_seen;
  if (report != nullptr) *report = counts;
  return result;
}

void Describe(OptionsVisitor& visitor, ColourOptions& options) {
  visitor.Field(
      "segment_only", options.segment_only, "take colours from the object's segment alone");
}

}  // namespace deepslam::mesh
