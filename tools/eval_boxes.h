// What `eval objects` says of boxes alone.
#pragma once

#include <span>
#include <vector>

#include "deepslam/artifact/json_value.h"
#include "deepslam/eval/box_score.h"

namespace deepslam::tools {

// Sums over the pairs of a command line. IoU 0.25 and 0.5.
struct BoxFigures {
  std::vector<eval::BoxScore> scores;
  eval::Confusions confusions;  // at 0.25
  int num_merged = 0;           // mapped boxes that hold several true ones
  int num_split = 0;            // true boxes that hold several mapped ones
  artifact::JsonArray matches;

  void Add(std::span<const eval::PlacedBox> mapped,
           std::span<const eval::PlacedBox> truth,
           int pair);
};

[[nodiscard]] artifact::JsonValue ToJson(const BoxFigures& figures);
// To stderr.
void Print(const BoxFigures& figures);

}  // namespace deepslam::tools
