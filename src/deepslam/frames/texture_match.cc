#include "deepslam/frames/texture_match.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "deepslam/core/wide_vectors.h"
#include "deepslam/frames/local_contrast.h"

namespace deepslam {
namespace {

constexpr double kMinShareInside = 0.3;  // of the points, inside the other image
constexpr int kPatches = 4;              // across and down
constexpr double kAlike = 0.3;           // twice what chance leaves over a patch
constexpr float kMinPointZM = 0.05F;     // nearer points fall nowhere

}  // namespace

TextureMatch::TextureMatch(const View& i,
                           const View& j,
                           const UnfilledVector<float>& depth_j_m,
                           int stride)
    : camera_(i.camera), image_(NormaliseLocalContrast(i.intensity)) {
  const Image<float> texture = NormaliseLocalContrast(j.intensity);
  double depth_m = 0, squared = 0;
  for (int v = stride / 2; v < j.camera.height; v += stride) {
    for (int u = stride / 2; u < j.camera.width; u += stride) {
      const float z = depth_j_m[static_cast<std::size_t>(v * j.camera.width + u)];
      if (!(z > 0)) continue;
      const Eigen::Vector3d ray = j.camera.Ray(u, v);
      const Eigen::Vector3f p = (static_cast<double>(z) * ray).cast<float>();
      const int patch = kPatches * v / j.camera.height * kPatches + kPatches * u / j.camera.width;
      points_.push_back({p.x(), p.y(), p.z(), texture(u, v), patch});
      depth_m += static_cast<double>(z);
      squared += ray.head<2>().squaredNorm();
    }
  }
  if (!(squared > 0)) return;
  mean_depth_m_ = depth_m / static_cast<double>(points_.size());
  rms_tangent_ = std::sqrt(squared / static_cast<double>(points_.size()));
}

DEEPSLAM_WIDE_VECTORS TextureMatch::Comparison TextureMatch::Compare(const Pose3& i_from_j,
                                                                     int patch) const {
  const Eigen::Matrix3f r = i_from_j.rotation.toRotationMatrix().cast<float>();
  const Eigen::Vector3f t = i_from_j.translation_m.cast<float>();
  const auto fx = static_cast<float>(camera_.fx), fy = static_cast<float>(camera_.fy);
  const auto cx = static_cast<float>(camera_.cx), cy = static_cast<float>(camera_.cy);
  const auto right = static_cast<float>(camera_.width - 1);
  const auto bottom = static_cast<float>(camera_.height - 1);
  double n = 0, a = 0, b = 0, aa = 0, bb = 0, ab = 0;
  for (const Point& p : points_) {
    if (patch != kAllPatches && p.patch != patch) continue;
    const float z = r(2, 0) * p.x + r(2, 1) * p.y + r(2, 2) * p.z + t.z();
    if (z <= kMinPointZM) continue;
    const float u = fx * (r(0, 0) * p.x + r(0, 1) * p.y + r(0, 2) * p.z + t.x()) / z + cx;
    const float v = fy * (r(1, 0) * p.x + r(1, 1) * p.y + r(1, 2) * p.z + t.y()) / z + cy;
    if (!(u >= 0 && v >= 0 && u < right && v < bottom)) continue;
    const int left = static_cast<int>(u), top = static_cast<int>(v);
    const float du = u - static_cast<float>(left), dv = v - static_cast<float>(top);
    const float* const upper = image_.row(top) + left;
    const float* const lower = upper + camera_.width;
    const float above = upper[0] + du * (upper[1] - upper[0]);
    const float below = lower[0] + du * (lower[1] - lower[0]);
    const auto value = static_cast<double>(above + dv * (below - above));
    const auto own = static_cast<double>(p.value);
    n += 1;
    a += own;
    b += value;
    aa += own * own;
    bb += value * value;
    ab += own * value;
  }
  const double num_patches = patch == kAllPatches ? 1 : kPatches * kPatches;
  if (n < std::max(1.0, kMinShareInside * static_cast<double>(points_.size()) / num_patches))
    return {};
  const double squared = (aa - a * a / n) * (bb - b * b / n);
  return {n, squared > 0 ? (ab - a * b / n) / std::sqrt(squared) : 0};
}

double TextureMatch::ShareOfPatches(const Pose3& i_from_j) const {
  int num = 0, num_alike = 0;
  for (int patch = 0; patch < kPatches * kPatches; ++patch) {
    const Comparison comparison = Compare(i_from_j, patch);
    if (comparison.num_points == 0) continue;
    ++num;
    num_alike += comparison.correlation >= kAlike ? 1 : 0;
  }
  return num > 0 ? static_cast<double>(num_alike) / num : 0;
}

double TextureMatch::DistancePx(const Pose3& one_i_from_j, const Pose3& other_i_from_j) const {
  double sum = 0;
  int count = 0;
  for (const Point& p : points_) {
    const Eigen::Vector3d point = Eigen::Vector3f(p.x, p.y, p.z).cast<double>();
    const auto one = camera_.Project(one_i_from_j * point);
    const auto other = camera_.Project(other_i_from_j * point);
    if (!one || !other) continue;
    sum += (*one - *other).squaredNorm();
    ++count;
  }
  return count > 0 ? std::sqrt(sum / count) : 0;
}

}  // namespace deepslam
