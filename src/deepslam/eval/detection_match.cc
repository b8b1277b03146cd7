#include "deepslam/eval/detection_match.h"

#include <algorithm>
#include <tuple>

#include "deepslam/geometry/pixel_box.h"

namespace deepslam::eval {

std::vector<Box2> VisibleBoxes(const Image<std::uint16_t>& instances, int count, int min_pixels) {
  std::vector<Box2> boxes(static_cast<std::size_t>(count));
  std::vector<int> pixels(boxes.size(), 0);
  for (int v = 0; v < instances.height(); ++v) {
    for (int u = 0; u < instances.width(); ++u) {
      const int number = instances(u, v);
      if (number < 1 || number > count) continue;
      const auto n = static_cast<std::size_t>(number - 1);
      ++pixels[n];
      ExtendByPixel(u, v, boxes[n]);
    }
  }
  for (std::size_t n = 0; n < boxes.size(); ++n) {
    if (pixels[n] < min_pixels) boxes[n] = Box2();
  }
  return boxes;
}

std::vector<BoxMatch> MatchBoxes(std::span<const ImageBox> detected,
                                 std::span<const ImageBox> truth,
                                 double min_iou) {
  struct Pair {
    double iou;
    BoxMatch match;
  };
  std::vector<Pair> pairs;
  for (std::size_t d = 0; d < detected.size(); ++d) {
    for (std::size_t t = 0; t < truth.size(); ++t) {
      const double iou = IntersectionOverUnion(detected[d].box_px, truth[t].box_px);
      if (iou < min_iou) continue;
      pairs.push_back({iou, {d, t, detected[d].class_name == truth[t].class_name}});
    }
  }
  std::stable_sort(pairs.begin(), pairs.end(), [](const Pair& a, const Pair& b) {
    return std::tuple(a.match.same_class, a.iou) > std::tuple(b.match.same_class, b.iou);
  });
  std::vector<bool> detected_taken(detected.size(), false);
  std::vector<bool> truth_taken(truth.size(), false);
  std::vector<BoxMatch> matches;
  for (const Pair& pair : pairs) {
    if (detected_taken[pair.match.detected] || truth_taken[pair.match.truth]) continue;
    detected_taken[pair.match.detected] = true;
    truth_taken[pair.match.truth] = true;
    matches.push_back(pair.match);
  }
  std::sort(matches.begin(), matches.end(), [](const BoxMatch& a, const BoxMatch& b) {
    return a.truth < b.truth;
  });
  return matches;
}

}  // namespace deepslam::eval
