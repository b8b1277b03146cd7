#include "deepslam/artifact/scene_json.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <fmt/format.h>

namespace deepslam::artifact {
namespace {

constexpr Range kImageSide{1, 1 << 15};
// Of a number that was written in full; nobody else writes these files.
constexpr double kUnitTolerance = 1e-6;

constexpr std::array<std::string_view, 4> kTrackingNames = {
    "tracked", "degenerate", "lost", "unreadable"};
constexpr std::array<std::string_view, 3> kDetectionNames = {"network", "file", "cluster"};

template <int kSize>
void DescribeRowMajor(JsonVisitor& visitor, Eigen::Matrix<double, kSize, kSize>& matrix) {
  Eigen::Matrix<double, kSize, kSize, Eigen::RowMajor> rows = matrix;
  visitor.Numbers({rows.data(), kSize * kSize});
  if (visitor.reading()) matrix = rows;
}

struct ImageSide {
  int px = 1;
};
struct ImageSize {
  ImageSide height;
  ImageSide width;
};

}  // namespace

void Describe(JsonVisitor& visitor, ImageSide& side) { visitor.Value(side.px, kImageSide); }
void Describe(JsonVisitor& visitor, ImageSize& size) { visitor.Columns(size.height, size.width); }

void Describe(JsonVisitor& visitor, Eigen::Vector3d& value) { visitor.Numbers({value.data(), 3}); }

void Describe(JsonVisitor& visitor, Eigen::Quaterniond& rotation) {
  visitor.Numbers({rotation.coeffs().data(), 4});
  if (!visitor.reading() || std::abs(rotation.norm() - 1.0) <= kUnitTolerance) return;
  visitor.Fail({}, fmt::format("has norm {}, must be a unit quaternion", rotation.norm()));
  rotation = Eigen::Quaterniond::Identity();
}

void Describe(JsonVisitor& visitor, Pose3& b_from_a) {
  visitor.Field("rotation_xyzw", b_from_a.rotation);
  visitor.Field("translation_m", b_from_a.translation_m);
}

void Describe(JsonVisitor& visitor, Plane& plane) {
  visitor.Field("normal", plane.normal);
  visitor.Field("d_m", plane.d_m);
  if (visitor.reading() && std::abs(plane.normal.norm() - 1.0) > kUnitTolerance)
    visitor.Fail({}, fmt::format("has a normal of length {}, must be 1", plane.normal.norm()));
}

void Describe(JsonVisitor& visitor, Box2& box) {
  std::array<double, 4> numbers = {
      box.u_min, box.v_min, box.u_max - box.u_min, box.v_max - box.v_min};
  visitor.Numbers(numbers);
  if (!visitor.reading()) return;
  box = {numbers[0], numbers[1], numbers[0] + numbers[2], numbers[1] + numbers[3]};
}

void Describe(JsonVisitor& visitor, Box3& box) {
  if (visitor.Null(box.empty())) return;
  visitor.Field("min", box.min);
  visitor.Field("max", box.max);
}

void Describe(JsonVisitor& visitor, PixelMask& mask) {
  if (visitor.Null(mask.empty())) return;
  ImageSize size{{mask.height()}, {mask.width()}};
  std::string counts = mask.rle();
  visitor.Field("size", size);
  visitor.Field("counts", counts);
  if (!visitor.reading()) return;
  Result<PixelMask> read = PixelMask::FromRle(counts, size.width.px, size.height.px);
  if (read.ok()) {
    mask = std::move(read).value();
  } else {
    visitor.Fail("counts", ": " + read.error().message);
  }
}

void Describe(JsonVisitor& visitor, Rgb8& colour) { visitor.Columns(colour.r, colour.g, colour.b); }

void Describe(JsonVisitor& visitor, Eigen::Matrix3d& matrix) {
  DescribeRowMajor<3>(visitor, matrix);
}
void Describe(JsonVisitor& visitor, Matrix6d& matrix) { DescribeRowMajor<6>(visitor, matrix); }
void Describe(JsonVisitor& visitor, SymmetricMatrix6d& matrix) {
  Matrix6d full = matrix.Full();
  Describe(visitor, full);
  if (visitor.reading()) matrix = full;
}

void Describe(JsonVisitor& visitor, ViewRegistration& view) {
  visitor.Maybe("view", view.view);
  visitor.Maybe("frame", view.frame);
  visitor.Field("ok", view.ok);
  visitor.Field("reason", view.reason);
  visitor.Field("camera_from_object", view.camera_from_object);
  visitor.Field("rmse_m", view.rmse_m);
  visitor.Field("inlier_share", view.inlier_share);
  visitor.Field("information", view.information);
  visitor.Field("yaw_free", view.yaw_free);
}

void Describe(JsonVisitor& visitor, TrackingStatus& status) {
  visitor.Choice(status, kTrackingNames);
}
void Describe(JsonVisitor& visitor, DetectionSource& source) {
  visitor.Choice(source, kDetectionNames);
}
void Describe(JsonVisitor& visitor, CandidateSource& source) {
  std::array<std::string_view, kNumCandidateSources> names;
  std::ranges::transform(AllSourceTraits(), names.begin(), &SourceTraits::name);
  visitor.Choice(source, names);
}

}  // namespace deepslam::artifact
