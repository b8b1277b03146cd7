#include "eval_boxes.h"

#include <array>
#include <cstddef>
#include <utility>

#include <fmt/format.h>

namespace deepslam::tools {
namespace {

using artifact::JsonArray;
using artifact::JsonObject;
using artifact::JsonValue;

constexpr std::array<double, 2> kMinIous = {0.25, 0.5};

JsonValue ToJson(const eval::BoxScore& score) {
  JsonObject row;
  row.emplace("min_iou", score.min_iou);
  row.emplace("num_true", score.num_true);
  row.emplace("num_mapped", score.num_estimated);
  row.emplace("num_found", score.num_found);
  row.emplace("num_right_class", score.num_right_class);
  row.emplace("recall", score.recall());
  row.emplace("recall_right_class", score.recall_right_class());
  row.emplace("precision", score.precision());
  row.emplace("precision_right_class", score.precision_right_class());
  return JsonValue(std::move(row));
}

}  // namespace

void BoxFigures::Add(std::span<const eval::PlacedBox> mapped,
                     std::span<const eval::PlacedBox> truth,
                     int pair) {
  const std::vector<eval::PlacedBoxMatch> of_pair = eval::MatchPlacedBoxes(mapped, truth);
  scores.resize(kMinIous.size());
  for (std::size_t n = 0; n < kMinIous.size(); ++n) {
    scores[n].min_iou = kMinIous[n];
    scores[n] += eval::ScoreBoxes(mapped, truth, of_pair, kMinIous[n]);
  }
  for (const auto& [classes, count] :
       eval::CountConfusions(mapped, truth, of_pair, kMinIous.front()))
    confusions[classes] += count;
  num_merged +=
      static_cast<int>(eval::HoldersOfSeveral(mapped, truth, of_pair, kMinIous.front()).size());
  num_split += static_cast<int>(
      eval::HoldersOfSeveral(truth, mapped, eval::Turned(of_pair), kMinIous.front()).size());
  for (const eval::PlacedBoxMatch& match : of_pair) {
    JsonObject row;
    row.emplace("pair", pair);
    row.emplace("true_index", static_cast<int>(match.truth));
    row.emplace("mapped_index", static_cast<int>(match.estimated));
    row.emplace("true_class", truth[match.truth].class_name);
    row.emplace("mapped_class", mapped[match.estimated].class_name);
    row.emplace("iou", match.iou);
    matches.emplace_back(std::move(row));
  }
}

JsonValue ToJson(const BoxFigures& figures) {
  JsonArray scores;
  for (const eval::BoxScore& score : figures.scores) scores.emplace_back(ToJson(score));
  JsonArray confusions;
  for (const auto& [classes, count] : figures.confusions) {
    JsonObject row;
    row.emplace("true_class", classes.first);
    row.emplace("mapped_class", classes.second);
    row.emplace("count", count);
    confusions.emplace_back(std::move(row));
  }
  JsonObject document;
  document.emplace("scores", std::move(scores));
  document.emplace("confusions", std::move(confusions));
  document.emplace("num_merged", figures.num_merged);
  document.emplace("num_split", figures.num_split);
  document.emplace("matches", figures.matches);
  return JsonValue(std::move(document));
}

void Print(const BoxFigures& figures) {
  for (const eval::BoxScore& score : figures.scores) {
    fmt::print(stderr,
               "boxes at IoU {:.2f}: recall {:.3f} (right class {:.3f}), precision {:.3f} (right "
               "class {:.3f})\n",
               score.min_iou,
               score.recall(),
               score.recall_right_class(),
               score.precision(),
               score.precision_right_class());
  }
  for (const auto& [classes, count] : figures.confusions)
    fmt::print(stderr, "{} taken for {}: {}\n", classes.first, classes.second, count);
  fmt::print(stderr, "merged {}, split {}\n", figures.num_merged, figures.num_split);
}

}  // namespace deepslam::tools
