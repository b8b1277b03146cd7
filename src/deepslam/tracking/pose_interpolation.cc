#include "deepslam/tracking/pose_interpolation.h"

#include <algorithm>
#include <cstddef>

#include "deepslam/core/check.h"

namespace deepslam::tracking {
namespace {

Pose3 Between(const Pose3& a, const Pose3& b, double share) {
  return {a.rotation.slerp(share, b.rotation).normalized(),
          (1 - share) * a.translation_m + share * b.translation_m};
}

}  // namespace

std::vector<Pose3> InterpolateMissing(std::span<const std::optional<Pose3>> poses,
                                      std::span<const double> times_s) {
  DEEPSLAM_CHECK(poses.size() == times_s.size(), "one time per pose");
  std::vector<Pose3> result(poses.size());
  std::optional<std::size_t> before;
  for (std::size_t k = 0; k < poses.size(); ++k) {
    if (!poses[k]) continue;
    result[k] = *poses[k];
    for (std::size_t gap = before ? *before + 1 : 0; gap < k; ++gap) {
      if (!before) {
        result[gap] = *poses[k];
        continue;
      }
      const double interval_s = times_s[k] - times_s[*before];
      const double by_time = (times_s[gap] - times_s[*before]) / interval_s;
      const double by_index = static_cast<double>(gap - *before) / static_cast<double>(k - *before);
      const bool usable = interval_s > 0 && by_time >= 0 && by_time <= 1;
      result[gap] = Between(*poses[*before], *poses[k], usable ? by_time : by_index);
    }
    before = k;
  }
  for (std::size_t k = before ? *before + 1 : poses.size(); k < poses.size(); ++k)
    result[k] = *poses[*before];
  return result;
}

}  // namespace deepslam::tracking
