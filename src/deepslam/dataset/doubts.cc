#include "deepslam/dataset/doubts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string_view>

#include <fmt/format.h>

#include "deepslam/core/angles.h"
#include "deepslam/core/order_statistics.h"

namespace deepslam::dataset {
namespace {

// Of the image's side, from its middle: lenses sit within a few hundredths.
constexpr double kFarthestFromMiddle = 0.2;
constexpr double kNarrowestDeg = 25;  // cameras for rooms see 40 and more
constexpr double kWidestDeg = 130;    // Azure Kinect's wide depth camera sees 120
// Between frames that somebody recorded to be tracked.
constexpr double kShortestIntervalS = 0.0005;
constexpr double kLongestIntervalS = 5;  // milliseconds taken for seconds are 33 apart
constexpr std::size_t kDepthStep = 17;   // every which pixel is looked at
// Between the brightest and the darkest grey level, of 255: a picture of one tone has so much after
// JPEG, a blank wall more, as light falls off across it.
constexpr int kLeastContrast = 12;

double ViewDeg(int side_px, double focal_px) {
  return 2 * kDegPerRad * std::atan(0.5 * side_px / focal_px);
}

// The unit that would make frames of a recording out of these intervals; empty where none does.
std::string_view LikelyUnit(double interval) {
  struct Unit {
    std::string_view name;
    double per_s;
  };
  constexpr std::array<Unit, 3> kUnits = {
      {{"milliseconds", 1e3}, {"microseconds", 1e6}, {"nanoseconds", 1e9}}};
  for (const Unit& unit : kUnits) {
    const double interval_s = interval / unit.per_s;
    if (interval_s > 0.004 && interval_s < 0.5) return unit.name;
  }
  return {};
}

// Between times that ascend; nothing of fewer than two of them.
std::optional<double> MedianInterval(std::span<const double> times_s) {
  std::vector<double> intervals_s;
  for (std::size_t k = 1; k < times_s.size(); ++k) {
    const double interval_s = times_s[k] - times_s[k - 1];
    if (interval_s > 0) intervals_s.push_back(interval_s);
  }
  if (intervals_s.size() < 2) return std::nullopt;
  return Median(intervals_s);
}

bool IsOneTone(const IntensityImage& picture) {
  const auto [darkest, brightest] = std::ranges::minmax(picture);
  return brightest - darkest < kLeastContrast;
}

}  // namespace

std::vector<std::string> CameraDoubts(const PinholeCamera& camera) {
  std::vector<std::string> doubts;
  const double from_middle_u = std::abs(camera.cx - 0.5 * (camera.width - 1)) / camera.width;
  const double from_middle_v = std::abs(camera.cy - 0.5 * (camera.height - 1)) / camera.height;
  if (std::max(from_middle_u, from_middle_v) > kFarthestFromMiddle) {
    doubts.push_back(fmt::format(
        "the principal point ({:.1f}, {:.1f}) lies far from the middle of {} x {} px: intrinsics "
        "of another image size? 'camera' in capture.yaml corrects them",
        camera.cx,
        camera.cy,
        camera.width,
        camera.height));
  }
  const double view_deg = ViewDeg(camera.width, camera.fx);
  if (view_deg < kNarrowestDeg || view_deg > kWidestDeg) {
    doubts.push_back(fmt::format(
        "the camera's view is {:.0f} deg wide (fx {:.1f} px, {} px): intrinsics of another image "
        "size? 'camera' in capture.yaml corrects them",
        view_deg,
        camera.fx,
        camera.width));
  }
  return doubts;
}

std::string_view UnitOfTimes(std::span<const double> times_s) {
  const std::optional<double> interval_s = MedianInterval(times_s);
  return interval_s && *interval_s > kLongestIntervalS ? LikelyUnit(*interval_s)
                                                       : std::string_view();
}

std::vector<std::string> TimeDoubts(std::span<const double> times_s) {
  const std::optional<double> interval_s = MedianInterval(times_s);
  if (!interval_s || (*interval_s >= kShortestIntervalS && *interval_s <= kLongestIntervalS))
    return {};
  const std::string_view unit = LikelyUnit(*interval_s);
  return {fmt::format(
      "frames are {:.3g} s apart (median): times have to be in seconds{}; convert the lists",
      *interval_s,
      unit.empty() ? std::string() : fmt::format(", these look like {}", unit))};
}

std::vector<std::string> ColourDoubts(std::span<const IntensityImage> pictures) {
  const auto num_flat = std::ranges::count_if(pictures, IsOneTone);
  if (2 * num_flat <= std::ssize(pictures)) return {};
  return {
      fmt::format("{} of {} pictures looked at are of one tone: nothing can be recognised in them; "
                  "are they the capture's colour images?",
                  num_flat,
                  pictures.size())};
}

std::vector<std::string> DepthDoubts(std::span<const DepthImage> depths_m) {
  std::vector<float> valid_m;
  for (const DepthImage& depth_m : depths_m) {
    for (std::size_t k = 0; k < depth_m.size(); k += kDepthStep) {
      if (depth_m.data()[k] > 0) valid_m.push_back(depth_m.data()[k]);
    }
  }
  if (valid_m.empty()) return {};
  const double median_m = Median(valid_m);
  if (median_m >= kNearestMedianM && median_m <= kFarthestMedianM) return {};
  return {fmt::format(
      "half of the depth is {} than {:.2f} m, in rooms it is 1 to 4: units of another camera? "
      "'depth_units_per_m' in capture.yaml corrects them (TUM's 5000, most others' 1000)",
      median_m < kNearestMedianM ? "nearer" : "farther",
      median_m)};
}

}  // namespace deepslam::dataset
