#include "deepslam/loop/keyframe_features.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <optional>

#include <opencv2/core.hpp>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>

namespace deepslam::loop {
namespace {

constexpr int kWorkWidth_px = 640;  // wider images are reduced by a whole factor
constexpr int kCellsAcross = 8;     // cells of a picture among which corners are spread
constexpr int kCellsDown = 6;       // with 8 across they are square at 4:3
constexpr int kCellShare = 4;       // a cell may hold this many times its even share
constexpr int kFastThreshold = 10;  // grey levels; rooms have little contrast
// Of blobs, as a share of the grey levels: half of what Lowe asks for, as blur leaves little.
constexpr double kBlobContrast = 0.02;
constexpr int kOctaveLayers = 3;       // Lowe 2004
constexpr double kMaxEdgeRatio = 10;   // Lowe 2004
constexpr double kFirstBlur_px = 1.6;  // Lowe 2004
constexpr int kEdge_px = 19;  // rim without corners: reach of ORB's turned pattern (ORB-SLAM's too)
// Beyond, structured light is off by more than a pose may be.
constexpr float kMaxCornerDepth_m = 8.0F;
// Depth within the 3 x 3 pixels about a corner: farther apart, it lies on an edge of something.
constexpr float kMaxStep = 0.04F;      // of the depth
constexpr std::size_t kMinDepths = 5;  // of nine: more than half

cv::Mat Grey(const ColourImage& colour, int factor) {
  // OpenCV does not write to it.
  const cv::Mat rgb(colour.height(),
                    colour.width(),
                    CV_8UC3,
                    const_cast<Rgb8*>(colour.data()));  // NOLINT(*-const-cast)
  cv::Mat grey;
  cv::cvtColor(rgb, grey, cv::COLOR_RGB2GRAY);
  if (factor == 1) return grey;
  cv::Mat reduced;
  cv::resize(grey, reduced, cv::Size(grey.cols / factor, grey.rows / factor), 0, 0, cv::INTER_AREA);
  return reduced;
}

// Median depth about a pixel; nothing at holes and steps.
std::optional<float> DepthAt(const DepthImage& depth_m, int u, int v) {
  std::array<float, 9> near{};
  std::size_t count = 0;
  for (int dv = -1; dv <= 1; ++dv) {
    for (int du = -1; du <= 1; ++du) {
      if (!depth_m.Contains(u + du, v + dv)) continue;
      const float z = depth_m(u + du, v + dv);
      if (z > 0 && z < kMaxCornerDepth_m) near[count++] = z;
    }
  }
  if (count < kMinDepths) return std::nullopt;
  std::sort(near.begin(), near.begin() + static_cast<std::ptrdiff_t>(count));
  const float median = near[count / 2];
  if (near[count - 1] - near[0] > kMaxStep * median) return std::nullopt;
  return median;
}

// Corners with depth, strongest first, no cell of the image with more than its share.
struct Corners {
  std::vector<cv::KeyPoint> keypoints;
  std::vector<Eigen::Vector3f> points_camera;
};

Corners Choose(std::vector<cv::KeyPoint> found,
               const cv::Size& size,
               const Frame& frame,
               const PinholeCamera& camera,
               int factor,
               int max_features) {
  std::stable_sort(found.begin(), found.end(), [](const cv::KeyPoint& a, const cv::KeyPoint& b) {
    if (a.response != b.response) return a.response > b.response;
    return std::pair(a.pt.y, a.pt.x) < std::pair(b.pt.y, b.pt.x);
  });
  const int most = std::max(1, kCellShare * max_features / (kCellsAcross * kCellsDown));
  std::array<int, kCellsAcross * kCellsDown> in_cell{};
  Corners chosen;
  for (const cv::KeyPoint& keypoint : found) {
    if (static_cast<int>(chosen.keypoints.size()) >= max_features) break;
    const int column = std::clamp(
        static_cast<int>(keypoint.pt.x) * kCellsAcross / size.width, 0, kCellsAcross - 1);
    const int row =
        std::clamp(static_cast<int>(keypoint.pt.y) * kCellsDown / size.height, 0, kCellsDown - 1);
    int& count = in_cell[static_cast<std::size_t>(row * kCellsAcross + column)];
    if (count >= most) continue;
    // A reduced pixel's centre lies in the middle of its block.
    const float middle = 0.5F * static_cast<float>(factor - 1);
    const float u = static_cast<float>(factor) * keypoint.pt.x + middle;
    const float v = static_cast<float>(factor) * keypoint.pt.y + middle;
    const std::optional<float> depth_m =
        DepthAt(frame.depth_m, static_cast<int>(std::lround(u)), static_cast<int>(std::lround(v)));
    if (!depth_m) continue;
    ++count;
    chosen.keypoints.push_back(keypoint);
    chosen.points_camera.push_back(
        camera.Unproject(static_cast<double>(u), static_cast<double>(v), *depth_m).cast<float>());
  }
  return chosen;
}

// The picture that a frame's points are looked for in; empty where nothing can be.
struct Picture {
  cv::Mat grey;
  int factor = 1;  // by which it is reduced
};

Picture PictureOf(const Frame& frame, int max_features) {
  const bool sizes_agree = frame.colour.width() == frame.depth_m.width() &&
                           frame.colour.height() == frame.depth_m.height();
  if (frame.colour.empty() || !sizes_agree || max_features < 1) return {};
  const int factor = std::max(1, (frame.colour.width() + kWorkWidth_px - 1) / kWorkWidth_px);
  Picture picture{Grey(frame.colour, factor), factor};
  if (std::min(picture.grey.cols, picture.grey.rows) <= 2 * kEdge_px) return {};
  return picture;
}

// Corners that `by` finds and describes, into features of either kind: their descriptors are the
// rows' bytes.
template <typename Features>
Features Extract(cv::Feature2D& by,
                 const Frame& frame,
                 const PinholeCamera& camera,
                 int max_features) {
  Features features;
  features.keyframe = frame.idx;
  const Picture picture = PictureOf(frame, max_features);
  if (picture.grey.empty()) return features;
  std::vector<cv::KeyPoint> found;
  by.detect(picture.grey, found);
  Corners corners =
      Choose(std::move(found), picture.grey.size(), frame, camera, picture.factor, max_features);
  if (corners.keypoints.empty()) return features;
  // compute() may leave corners out: their number in the list is kept with them.
  for (std::size_t k = 0; k < corners.keypoints.size(); ++k)
    corners.keypoints[k].class_id = static_cast<int>(k);
  cv::Mat descriptors;
  by.compute(picture.grey, corners.keypoints, descriptors);
  for (std::size_t k = 0; k < corners.keypoints.size(); ++k) {
    auto& descriptor = features.descriptors.emplace_back();
    std::memcpy(descriptor.data(), descriptors.ptr(static_cast<int>(k)), sizeof(descriptor));
    features.points_camera.push_back(
        corners.points_camera[static_cast<std::size_t>(corners.keypoints[k].class_id)]);
  }
  return features;
}

}  // namespace

KeyframeFeatures ExtractFeatures(const Frame& frame,
                                 const PinholeCamera& camera,
                                 int max_features) {
  // Twice as many, since some have no depth.
  const cv::Ptr<cv::ORB> orb = cv::ORB::create(2 * std::max(1, max_features),
                                               1.2F,
                                               8,
                                               kEdge_px,
                                               0,
                                               2,
                                               cv::ORB::HARRIS_SCORE,
                                               31,
                                               kFastThreshold);
  return Extract<KeyframeFeatures>(*orb, frame, camera, max_features);
}

GradientFeatures ExtractGradientFeatures(const Frame& frame,
                                         const PinholeCamera& camera,
                                         int max_features) {
  const cv::Ptr<cv::SIFT> sift = cv::SIFT::create(2 * std::max(1, max_features),
                                                  kOctaveLayers,
                                                  kBlobContrast,
                                                  kMaxEdgeRatio,
                                                  kFirstBlur_px,
                                                  CV_8U);
  return Extract<GradientFeatures>(*sift, frame, camera, max_features);
}

}  // namespace deepslam::loop
