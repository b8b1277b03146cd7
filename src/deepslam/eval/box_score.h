// Boxes of mapped objects against true ones: how many are found, how many are right, what was taken
// for what, what was merged and what was split. Needs boxes alone, no shapes.
#pragma once

#include <cstddef>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "deepslam/eval/placement.h"

namespace deepslam::eval {

inline constexpr std::string_view kBoxProtocol =
    "boxes: IoU of upright oriented boxes, greatest first, one to one; merged: a mapped box that "
    "holds the middles of two true boxes that no other matches at 0.25; split: the same the other "
    "way round";

// Intersection over union of two boxes that stand upright: turned about the world's z alone, what
// they lean besides is left out. In [0, 1].
[[nodiscard]] double BoxIou(const PlacedBox& a, const PlacedBox& b);

struct PlacedBoxMatch {
  std::size_t estimated = 0;
  std::size_t truth = 0;
  double iou = 0;  // above 0
};
// Pairs of the greatest IoU first, each box once. Ordered by truth.
[[nodiscard]] std::vector<PlacedBoxMatch> MatchPlacedBoxes(std::span<const PlacedBox> estimated,
                                                           std::span<const PlacedBox> truth);

struct BoxScore {
  double min_iou = 0;
  int num_true = 0;
  int num_estimated = 0;
  int num_found = 0;        // matched at this IoU at least
  int num_right_class = 0;  // and of the true class

  [[nodiscard]] double recall() const;              // 1 where nothing was there
  [[nodiscard]] double recall_right_class() const;  // 1 where nothing was there
  [[nodiscard]] double precision() const;           // 1 where nothing was claimed
  [[nodiscard]] double precision_right_class() const;
  BoxScore& operator+=(const BoxScore& other);  // of the same min_iou
};
[[nodiscard]] BoxScore ScoreBoxes(std::span<const PlacedBox> estimated,
                                  std::span<const PlacedBox> truth,
                                  std::span<const PlacedBoxMatch> matches,
                                  double min_iou);

// How often a true class was mapped as a class: (true, mapped), of matches of this IoU at least.
using Confusions = std::map<std::pair<std::string, std::string>, int>;
[[nodiscard]] Confusions CountConfusions(std::span<const PlacedBox> estimated,
                                         std::span<const PlacedBox> truth,
                                         std::span<const PlacedBoxMatch> matches,
                                         double min_iou);

// Boxes of `holders` that hold the middles of two or more of `held`. A middle counts only where its
// own box matches no other holder at `min_iou`: a table does not merge the chairs pushed under it.
// `matches` has (holder, held) as (estimated, truth). Ascending positions.
[[nodiscard]] std::vector<std::size_t> HoldersOfSeveral(std::span<const PlacedBox> holders,
                                                        std::span<const PlacedBox> held,
                                                        std::span<const PlacedBoxMatch> matches,
                                                        double min_iou);
// The same matches seen from the other side, for what was split.
[[nodiscard]] std::vector<PlacedBoxMatch> Turned(std::span<const PlacedBoxMatch> matches);

}  // namespace deepslam::eval
