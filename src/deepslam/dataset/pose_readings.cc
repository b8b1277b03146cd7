#include "deepslam/dataset/pose_readings.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>

namespace deepslam::dataset {
namespace {

// Points looked at, of a frame.
constexpr int kGridColumns = 24;
constexpr int kGridRows = 18;  // as 4 : 3
// A point lies on the other frame's surface within noise of depth, poses and moments.
constexpr double kOnSurfaceM = 0.02;
constexpr double kOnSurfaceShare = 0.01;  // of depth
// A pair of which so few points fall into the other picture, or onto depth, says nothing.
constexpr double kLeastInside = 0.25;
constexpr int kFewestMet = 20;     // a share of fewer points is off by 11 % and more
constexpr double kNearestM = 0.1;  // depth cameras measure nothing nearer
// A pair that fits this well under no reading shows too little in common, or noise.
constexpr double kUsableShare = 0.6;
constexpr int kFewestPairs = 3;  // one or two may fit another reading by chance
// Real captures with right poses have 0.8 to 1.0 and no other reading above it; those of other
// conventions less than 0.6, at pairs of equal distance.
constexpr double kGoodShare = 0.7;
constexpr double kClearlyBetter = 0.15;  // than the share of the reading that is stated
// Of 270 readings, one that changes several things fits better by chance: each more has to add
// this.
constexpr double kSharePerChange = 0.06;
// A reading that all but stops the camera fits what neighbours share. It has to fit better than
// without any motion, unless the poses as read fit nothing.
constexpr double kBetterThanStill = 0.1;
constexpr double kFitsNothing = 0.3;  // share that surfaces far apart meet by chance
// Lengths of poses out of structure from motion are of any unit: tried from a twentieth to twenty
// times as large, in steps that differ by less than what a surface's noise hides.
constexpr double kLargestScale = 20;
constexpr double kScaleStep = 1.25;  // half a step off is a tenth of the way between frames

// The latter two: where a layout turned the camera's axes from OpenGL's after it had read the
// numbers.
enum class Order { kAsRead, kWFirst, kWLast, kOpenGlWFirst, kOpenGlWLast };

// One way in which poses may have been written.
struct Reading {
  Order order = Order::kAsRead;
  bool camera_from_world = false;
  double metres = 1;                                              // of a unit of length
  Eigen::Matrix3d own_from_camera = Eigen::Matrix3d::Identity();  // axes of the poses' camera
  std::string_view axes;

  [[nodiscard]] std::vector<std::string> Changes() const {
    std::vector<std::string> words;
    if (order == Order::kWFirst || order == Order::kOpenGlWFirst)
      words.emplace_back("quaternions as qw qx qy qz");
    if (order == Order::kWLast || order == Order::kOpenGlWLast)
      words.emplace_back("quaternions as qx qy qz qw");
    if (camera_from_world) words.emplace_back("poses as camera from world");
    if (metres == 0.001) {
      words.emplace_back("positions in millimetres");
    } else if (metres == 0.01) {
      words.emplace_back("positions in centimetres");
    } else if (metres != 1) {
      words.push_back(
          fmt::format("positions {:.2g} times as large against depth (is "
                      "'depth_units_per_m' {:.2g} times what it should be?)",
                      metres,
                      1 / metres));
    }
    if (!axes.empty()) words.emplace_back(axes);
    return words;
  }
};

struct Axes {
  Eigen::Matrix3d own_from_camera;
  std::string_view words;
};

std::vector<Axes> AllAxes() {
  const Eigen::Matrix3d none = Eigen::Matrix3d::Identity();
  const Eigen::Matrix3d open_gl = Eigen::Vector3d(1, -1, -1).asDiagonal();
  const Eigen::Matrix3d mirrored = Eigen::Vector3d(1, -1, 1).asDiagonal();
  Eigen::Matrix3d quarter;
  quarter << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  const Eigen::Matrix3d half = quarter * quarter;
  Eigen::Matrix3d body;
  body << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  return {
      {none, ""},
      {open_gl, "camera axes y up, z back (OpenGL's)"},
      {mirrored, "axes of a left hand, y up, z forward (Unity's)"},
      {half, "pictures upside down against the camera axes"},
      {quarter, "pictures a quarter turn clockwise against the camera axes"},
      {half * quarter, "pictures a quarter turn anticlockwise against the camera axes"},
      {open_gl * half, "camera axes x left, y up, z back"},
      {open_gl * quarter, "camera axes y up, z back (OpenGL's) of pictures a quarter turn away"},
      {open_gl * half * quarter,
       "camera axes y up, z back (OpenGL's) of pictures a quarter turn away, the other way"},
      {body, "camera axes x forward, y left, z up (ROS's body)"}};
}

// Simple ones first: of equals the first is taken. The very first is as read.
std::vector<Reading> AllReadings() {
  std::vector<Reading> readings;
  for (const double metres : {1.0, 0.001, 0.01, 5.0, 0.2}) {
    for (const Axes& axes : AllAxes()) {
      for (const bool camera_from_world : {false, true}) {
        for (const Order order : {Order::kAsRead,
                                  Order::kWFirst,
                                  Order::kWLast,
                                  Order::kOpenGlWFirst,
                                  Order::kOpenGlWLast}) {
          readings.push_back({order, camera_from_world, metres, axes.own_from_camera, axes.words});
        }
      }
    }
  }
  for (double metres = 1 / kLargestScale; metres <= kLargestScale; metres *= kScaleStep)
    readings.push_back({Order::kAsRead, false, metres, Eigen::Matrix3d::Identity(), ""});
  return readings;
}

Eigen::Quaterniond Reordered(const Eigen::Quaterniond& read, Order order) {
  // Half a turn about x, which undoes itself but for the sign.
  const Eigen::Quaterniond open_gl(0, 1, 0, 0);
  switch (order) {
    case Order::kWFirst:
      return {read.x(), read.y(), read.z(), read.w()};
    case Order::kWLast:
      return {read.z(), read.w(), read.x(), read.y()};
    case Order::kOpenGlWFirst:
      return Reordered(read * open_gl, Order::kWFirst) * open_gl;
    case Order::kOpenGlWLast:
      return Reordered(read * open_gl, Order::kWLast) * open_gl;
    case Order::kAsRead:
      break;
  }
  return read;
}

// Rotation and position, m, in the world; the rotation may be a mirror's.
struct Placed {
  Eigen::Matrix3d rotation;
  Eigen::Vector3d position_m;
};

Placed Place(const Pose3& read, const Reading& reading) {
  const Eigen::Matrix3d rotation = Reordered(read.rotation, reading.order).toRotationMatrix();
  const Eigen::Vector3d position_m = reading.metres * read.translation_m;
  if (!reading.camera_from_world) return {rotation * reading.own_from_camera, position_m};
  const Eigen::Matrix3d inverse = rotation.transpose();
  return {inverse * reading.own_from_camera, -(inverse * position_m)};
}

std::vector<Eigen::Vector3d> PointsOf(const PinholeCamera& camera, const DepthImage& depth_m) {
  std::vector<Eigen::Vector3d> points;
  for (int row = 0; row < kGridRows; ++row) {
    const int v = row * (depth_m.height() - 1) / (kGridRows - 1);
    for (int column = 0; column < kGridColumns; ++column) {
      const int u = column * (depth_m.width() - 1) / (kGridColumns - 1);
      const float z_m = depth_m(u, v);
      if (z_m > 0) points.push_back(camera.Unproject(u, v, static_cast<double>(z_m)));
    }
  }
  return points;
}

// Of a's points that b saw something at: how many lie on it. Nothing where too few can tell.
std::optional<double> SharePlaced(const PinholeCamera& camera,
                                  const std::vector<Eigen::Vector3d>& points_a,
                                  const DepthImage& b_m,
                                  const Placed& a,
                                  const Placed& b) {
  const Eigen::Matrix3d b_from_a = b.rotation.transpose() * a.rotation;
  const Eigen::Vector3d shift_m = b.rotation.transpose() * (a.position_m - b.position_m);
  int num_inside = 0, num_met = 0, num_near = 0;
  for (const Eigen::Vector3d& p_a : points_a) {
    const Eigen::Vector3d p_b = b_from_a * p_a + shift_m;
    if (!(p_b.z() > kNearestM)) continue;
    const Eigen::Vector2d pixel = *camera.Project(p_b);
    if (!(pixel.x() > -0.5 && pixel.y() > -0.5 && pixel.x() < camera.width - 0.5 &&
          pixel.y() < camera.height - 0.5)) {
      continue;
    }
    ++num_inside;
    const double seen_m = static_cast<double>(
        b_m(static_cast<int>(std::lround(pixel.x())), static_cast<int>(std::lround(pixel.y()))));
    if (!(seen_m > 0)) continue;
    ++num_met;
    if (std::abs(seen_m - p_b.z()) < kOnSurfaceM + kOnSurfaceShare * p_b.z()) ++num_near;
  }
  if (num_inside < kLeastInside * static_cast<double>(points_a.size()) || num_met < kFewestMet)
    return std::nullopt;
  return static_cast<double>(num_near) / num_met;
}

using Shares = std::vector<std::optional<double>>;  // of each pair

double MeanOver(const Shares& shares, const std::vector<bool>& used, int num_used) {
  double sum = 0;
  for (std::size_t n = 0; n < shares.size(); ++n) sum += used[n] ? shares[n].value_or(0) : 0;
  return sum / num_used;
}

// Of every pair by one reading.
Shares SharesOf(const PinholeCamera& camera,
                std::span<const PosedPair> pairs,
                const std::vector<std::vector<Eigen::Vector3d>>& points,
                const Reading& reading) {
  Shares shares;
  for (std::size_t n = 0; n < pairs.size(); ++n) {
    shares.push_back(SharePlaced(camera,
                                 points[n],
                                 *pairs[n].b_m,
                                 Place(pairs[n].world_from_a, reading),
                                 Place(pairs[n].world_from_b, reading)));
  }
  return shares;
}

// Pairs that fit under some reading. Frames that see nothing in common by the poses as read tell
// nothing against these, unless that is so of most.
std::vector<bool> UsedPairs(const std::vector<Shares>& of_readings) {
  std::vector<bool> fitting, overlapping;
  for (std::size_t n = 0; n < of_readings.front().size(); ++n) {
    fitting.push_back(std::ranges::any_of(
        of_readings, [&](const Shares& shares) { return shares[n].value_or(0) >= kUsableShare; }));
    overlapping.push_back(fitting.back() && of_readings.front()[n].has_value());
  }
  const bool most = 2 * std::ranges::count(overlapping, true) >= std::ranges::count(fitting, true);
  return most ? overlapping : fitting;
}

}  // namespace

bool PoseFit::contradicts() const {
  return num_pairs >= kFewestPairs && !best_reading.empty() && best_worth >= kGoodShare &&
         best_worth - share >= kClearlyBetter;
}

PoseFit FitPoses(const PinholeCamera& camera, std::span<const PosedPair> pairs) {
  std::vector<std::vector<Eigen::Vector3d>> points;
  for (const PosedPair& pair : pairs) points.push_back(PointsOf(camera, *pair.a_m));
  const std::vector<Reading> readings = AllReadings();
  std::vector<Shares> shares;  // of each reading
  for (const Reading& reading : readings)
    shares.push_back(SharesOf(camera, pairs, points, reading));
  const std::vector<bool> used = UsedPairs(shares);
  PoseFit fit;
  fit.num_pairs = static_cast<int>(std::ranges::count(used, true));
  if (fit.num_pairs == 0) return fit;
  fit.share = fit.best_share = MeanOver(shares.front(), used, fit.num_pairs);
  double best_worth = fit.share;
  for (std::size_t k = 1; k < readings.size(); ++k) {
    const double share = MeanOver(shares[k], used, fit.num_pairs);
    const std::vector<std::string> changes = readings[k].Changes();
    const double worth = share - kSharePerChange * (static_cast<double>(changes.size()) - 1);
    if (worth <= best_worth) continue;
    if (readings[k].metres < 1 && fit.share >= kFitsNothing) {
      Reading still = readings[k];
      still.metres = 0;
      const Shares of_still = SharesOf(camera, pairs, points, still);
      if (share < MeanOver(of_still, used, fit.num_pairs) + kBetterThanStill) continue;
    }
    best_worth = worth;
    fit.best_share = share;
    fit.best_worth = worth;
    fit.best_reading = fmt::format("{}", fmt::join(changes, " and "));
  }
  return fit;
}

}  // namespace deepslam::dataset
