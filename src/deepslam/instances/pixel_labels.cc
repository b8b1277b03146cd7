#include "deepslam/instances/pixel_labels.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>

#include <Eigen/Geometry>

namespace deepslam::instances {
namespace {

// What a pixel may lie above floor or wall and be that, and the depth step that still joins two
// pixels: close to the camera, and more with the square of the depth, as the noise of structured
// light has it. Those of stage `segment`.
constexpr double kOnRoomM = 0.03;
constexpr double kOnRoomPerM2 = 0.006;  // 1/m: at 3 m 0.05 m more
constexpr double kStepM = 0.03;         // of neighbouring pixels
constexpr double kStepPerM2 = 0.012;    // 1/m: at 3 m 0.11 m more, as of surfaces seen at a slant
constexpr double kMarginVoxels = 2;     // that a thing's box leaves out of it

class PixelPoints {
 public:
  explicit PixelPoints(const MeasuredView& view)
      : rotation_(view.level_from_camera.rotation.toRotationMatrix().cast<float>()),
        translation_m_(view.level_from_camera.translation_m.cast<float>()),
        camera_(view.camera) {}
  [[nodiscard]] Eigen::Vector3f Level(int u, int v, float depth_m) const {
    return rotation_ * camera_.Unproject(u, v, depth_m).cast<float>() + translation_m_;
  }

 private:
  Eigen::Matrix3f rotation_;
  Eigen::Vector3f translation_m_;
  PinholeCamera camera_;
};

// Where a thing's pixels may lie: its box, wider by a margin, down to the floor.
class Bounds {
 public:
  Bounds(const UprightBox& box, double margin_m)
      : x_axis_(static_cast<float>(std::cos(box.yaw_rad)),
                static_cast<float>(std::sin(box.yaw_rad))),
        centre_m_(box.centre_m.cast<float>()),
        half_m_(static_cast<float>(box.length_m / 2 + margin_m),
                static_cast<float>(box.width_m / 2 + margin_m)),
        top_m_(static_cast<float>(box.top_m + margin_m)) {}
  [[nodiscard]] bool IsOver(const Eigen::Vector3f& p_level) const {
    const Eigen::Vector2f from_centre = p_level.head<2>() - centre_m_;
    const Eigen::Vector2f y_axis(-x_axis_.y(), x_axis_.x());
    return std::abs(x_axis_.dot(from_centre)) <= half_m_.x() &&
           std::abs(y_axis.dot(from_centre)) <= half_m_.y();
  }
  [[nodiscard]] bool Contains(const Eigen::Vector3f& p_level) const {
    return p_level.z() <= top_m_ && IsOver(p_level);
  }

 private:
  Eigen::Vector2f x_axis_;
  Eigen::Vector2f centre_m_;
  Eigen::Vector2f half_m_;
  float top_m_;
};

// On the floor, or on the surface of the room's structure.
bool IsRoom(const SurfaceElements& elements,
            int element,
            const Eigen::Vector3f& p,
            double depth_m) {
  const auto tolerance_m = static_cast<float>(kOnRoomM + kOnRoomPerM2 * depth_m * depth_m);
  if (p.z() < tolerance_m) return true;
  if (element < 0) return false;
  const auto i = static_cast<std::size_t>(element);
  return std::abs(elements.normals()[i].dot(p - elements.points()[i])) < tolerance_m;
}

struct Pixel {
  int u = 0;
  int v = 0;
};

// Whether a mask of `instance` may take pixels with that label: nobody's, or those of a piece that
// detections name alike and that is no object by itself.
bool IsFree(const Instances& instances, int label, int instance) {
  if (label == kLoosePixel) return true;
  if (label < 0 || label == instance) return false;
  const Instance& other = instances.instances[static_cast<std::size_t>(label)];
  return other.is_named && !other.rejection.empty() &&
         other.class_name == instances.instances[static_cast<std::size_t>(instance)].class_name;
}

// Cells of the ground plan round a thing, and which of them hang together with its box.
class OutlineCells {
 public:
  static constexpr int kOutside = -1;  // no cell

  OutlineCells(const UprightBox& box, double margin_m)
      : bounds_(box, margin_m + kCellM / 2), reach_m_(ReachOf(box)) {
    low_m_ = box.centre_m.cast<float>() - Eigen::Vector2f::Constant(reach_m_);
    side_ = static_cast<int>(std::ceil(2 * reach_m_ / kCellM));
    state_.assign(static_cast<std::size_t>(side_) * static_cast<std::size_t>(side_), State::kEmpty);
  }

  // Index of a cell; kOutside: farther than any part of the thing may lie.
  [[nodiscard]] int At(const Eigen::Vector3f& p_level) const {
    const Eigen::Vector2f place = (p_level.head<2>() - low_m_) / kCellM;
    if (!(place.minCoeff() >= 0) || !(place.maxCoeff() < static_cast<float>(side_)))
      return kOutside;
    return static_cast<int>(place.y()) * side_ + static_cast<int>(place.x());
  }
  void Add(int cell) { state_[static_cast<std::size_t>(cell)] = State::kShown; }
  // From those over the box to all neighbours in turn.
  void Join() {
    std::vector<int> waiting;
    for (int cell = 0; cell < side_ * side_; ++cell) {
      if (state_[static_cast<std::size_t>(cell)] == State::kShown && bounds_.IsOver(Middle(cell)))
        Take(cell, waiting);
    }
    while (!waiting.empty()) {
      const int from = waiting.back();
      waiting.pop_back();
      const int x = from % side_;
      const int y = from / side_;
      for (int ny = std::max(0, y - 1); ny <= std::min(side_ - 1, y + 1); ++ny) {
        for (int nx = std::max(0, x - 1); nx <= std::min(side_ - 1, x + 1); ++nx) {
          if (state_[static_cast<std::size_t>(ny * side_ + nx)] == State::kShown)
            Take(ny * side_ + nx, waiting);
        }
      }
    }
  }
  [[nodiscard]] bool IsJoined(int cell) const {
    return state_[static_cast<std::size_t>(cell)] == State::kJoined;
  }

 private:
  enum class State : char { kEmpty, kShown, kJoined };
  // Leaves of a plant and slats of a chair leave no wider gap, and other furniture a wider one.
  static constexpr float kCellM = 0.12F;
  // Beyond the corners of the box: as far as leaves hang over a pot.
  static constexpr double kOverhangM = 1;

  static float ReachOf(const UprightBox& box) {
    return static_cast<float>(std::hypot(box.length_m, box.width_m) / 2 + kOverhangM);
  }
  void Take(int cell, std::vector<int>& waiting) {
    state_[static_cast<std::size_t>(cell)] = State::kJoined;
    waiting.push_back(cell);
  }
  [[nodiscard]] Eigen::Vector3f Middle(int cell) const {
    return {low_m_.x() + kCellM * (static_cast<float>(cell % side_) + 0.5F),
            low_m_.y() + kCellM * (static_cast<float>(cell / side_) + 0.5F),
            0};
  }

  Bounds bounds_;
  float reach_m_;
  Eigen::Vector2f low_m_;
  int side_ = 0;
  std::vector<State> state_;
};

struct ShownPixel {
  int u = 0;
  int v = 0;
  int cell = OutlineCells::kOutside;
};

void FillGap(PixelLabels& labels, Pixel from, Pixel step, int count, int label) {
  for (int k = 1; k <= count; ++k)
    labels.instance(from.u + k * step.u, from.v + k * step.v) = label;
}

}  // namespace

PixelLabels LabelBySurface(const DividedSurface& surface, const MeasuredView& view) {
  const DepthImage& depth_m = view.depth_m;
  PixelLabels labels{Image<int>(depth_m.width(), depth_m.height(), kUnmeasuredPixel), {}};
  labels.num_visible.assign(surface.instances.instances.size(), 0);
  std::vector<char> is_visible(surface.elements.size(), 0);
  NearestElements::Cursor nearest(surface.nearest);
  const PixelPoints points(view);
  for (int v = 0; v < depth_m.height(); ++v) {
    for (int u = 0; u < depth_m.width(); ++u) {
      const float z_m = depth_m(u, v);
      if (!(z_m > 0)) continue;
      int& label = labels.instance(u, v);
      label = kRoomPixel;
      if (z_m > view.max_depth_m) continue;
      const Eigen::Vector3f p_level = points.Level(u, v, z_m);
      const int element = nearest.At(p_level);
      const int instance =
          element < 0 ? -1 : surface.instances.of_element[static_cast<std::size_t>(element)];
      if (instance < 0) {
        if (!IsRoom(surface.elements, element, p_level, z_m)) label = kLoosePixel;
        continue;
      }
      if (IsRoom(surface.elements, -1, p_level, z_m)) continue;
      label = instance;
      if (is_visible[static_cast<std::size_t>(element)] != 0) continue;
      is_visible[static_cast<std::size_t>(element)] = 1;
      ++labels.num_visible[static_cast<std::size_t>(instance)];
    }
  }
  return labels;
}

void GrowIntoMasks(const DividedSurface& surface,
                   const MeasuredView& view,
                   std::span<const ShownInstance> shown,
                   PixelLabels& labels) {
  const PixelPoints points(view);
  for (const ShownInstance& one : shown) {
    OutlineCells cells(
        surface.instances.instances[static_cast<std::size_t>(one.instance)].box_level,
        kMarginVoxels * surface.elements.voxel_m());
    std::vector<ShownPixel> free;
    const Mask mask = one.mask->Unpacked();
    const int height = std::min(mask.height(), labels.instance.height());
    const int width = std::min(mask.width(), labels.instance.width());
    for (int v = 0; v < height; ++v) {
      for (int u = 0; u < width; ++u) {
        if (mask(u, v) == 0 || !IsFree(surface.instances, labels.instance(u, v), one.instance))
          continue;
        const int cell = cells.At(points.Level(u, v, view.depth_m(u, v)));
        if (cell == OutlineCells::kOutside) continue;
        cells.Add(cell);
        free.push_back({u, v, cell});
      }
    }
    cells.Join();
    for (const ShownPixel& pixel : free) {
      if (cells.IsJoined(pixel.cell)) labels.instance(pixel.u, pixel.v) = one.instance;
    }
  }
}

void GrowIntoLoose(const DividedSurface& surface, const MeasuredView& view, PixelLabels& labels) {
  constexpr std::array<Pixel, 4> kNeighbours = {{{1, 0}, {-1, 0}, {0, 1}, {0, -1}}};
  const double margin_m = kMarginVoxels * surface.elements.voxel_m();
  std::vector<Bounds> bounds;
  for (const Instance& instance : surface.instances.instances)
    bounds.emplace_back(instance.box_level, margin_m);
  const PixelPoints points(view);
  Image<int>& label = labels.instance;
  const auto may_take = [&](Pixel from, Pixel to) {
    if (!label.Contains(to.u, to.v) || label(to.u, to.v) != kLoosePixel) return false;
    const float from_m = view.depth_m(from.u, from.v);
    const float to_m = view.depth_m(to.u, to.v);
    if (std::abs(to_m - from_m) > kStepM + kStepPerM2 * from_m * from_m) return false;
    return bounds[static_cast<std::size_t>(label(from.u, from.v))].Contains(
        points.Level(to.u, to.v, to_m));
  };
  // Ring by ring round all things at once, each ring in the order in which it was reached.
  std::vector<Pixel> ring;
  for (int v = 0; v < label.height(); ++v) {
    for (int u = 0; u < label.width(); ++u) {
      if (label(u, v) >= 0) ring.push_back({u, v});
    }
  }
  while (!ring.empty()) {
    std::vector<Pixel> next;
    for (const Pixel& from : ring) {
      for (const Pixel& step : kNeighbours) {
        const Pixel to{from.u + step.u, from.v + step.v};
        if (!may_take(from, to)) continue;
        label(to.u, to.v) = label(from.u, from.v);
        next.push_back(to);
      }
    }
    ring = std::move(next);
  }
}

void FillUnmeasured(const MeasuredView& view, double gap_m, PixelLabels& labels) {
  const Image<int> measured = labels.instance;
  const auto fill_line = [&](Pixel start, Pixel step, int length, double focal_px) {
    int before = -1;  // the last pixel with depth
    const auto at = [&](int k) { return Pixel{start.u + k * step.u, start.v + k * step.v}; };
    for (int k = 0; k < length; ++k) {
      const Pixel pixel = at(k);
      const int label = measured(pixel.u, pixel.v);
      if (label == kUnmeasuredPixel) continue;
      const int gap_px = k - before - 1;
      if (before >= 0 && gap_px > 0 && label >= 0) {
        const Pixel other = at(before);
        const double nearer_m =
            std::min(view.depth_m(pixel.u, pixel.v), view.depth_m(other.u, other.v));
        if (measured(other.u, other.v) == label && gap_px * nearer_m <= gap_m * focal_px)
          FillGap(labels, other, step, gap_px, label);
      }
      before = k;
    }
  };
  for (int v = 0; v < measured.height(); ++v)
    fill_line({0, v}, {1, 0}, measured.width(), view.camera.fx);
  for (int u = 0; u < measured.width(); ++u)
    fill_line({u, 0}, {0, 1}, measured.height(), view.camera.fy);
}

}  // namespace deepslam::instances
