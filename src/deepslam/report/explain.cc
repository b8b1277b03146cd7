#include "deepslam/report/explain.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

#include <fmt/format.h>

#include "deepslam/scene/upright_turns.h"

namespace deepslam::report {
namespace {

Fact CameraFact(const ReportContent& content) {
  const StatusCounts n = CountStatus(content.map.frames);
  const int without = n.lost + n.unreadable;
  Fact fact;
  fact.fine = without == 0 && n.degenerate == 0 && n.tracked > 0;
  fact.subject = "Camera path";
  fact.finding = fmt::format("known in {} of {} frames",
                             content.map.frames.size() - static_cast<std::size_t>(without),
                             content.map.frames.size());
  if (n.degenerate > 0) {
    fact.finding += fmt::format(
        "; {} of them show too little structure to be sure in every direction", n.degenerate);
  }
  if (!fact.fine) {
    fact.remedy =
        "Look at the path below. To record it better: move slowly, keep furniture or corners of "
        "the room in view, avoid bare walls and distances under half a metre.";
  }
  return fact;
}

// Whether most pictures lie on their side or upside down.
bool MostPicturesLie(const OptimizedMap& map) {
  std::vector<QuarterTurn> turns;
  for (const TrackedFrame& frame : map.frames) turns.push_back(UprightTurnIn(map, frame.frame));
  return MostCommon(turns) != QuarterTurn::kNone;
}

Fact FloorFact(const ReportContent& content) {
  if (content.map.has_ground) {
    std::string finding = "found; heights are measured from it";
    if (MostPicturesLie(content.map))
      finding += "; the camera was not held upright, so pictures are shown turned";
    return {true, "Floor", finding, {}};
  }
  return {false,
          "Floor",
          "not found; heights are relative to the first camera and objects may float or tilt",
          "Let the camera see some free floor early in the recording."};
}

Fact GraphFact(const ReportContent& content) {
  if (content.map.summary.converged)
    return {true, "Adjustment", "path, floor and objects were brought into agreement", {}};
  return {false,
          "Adjustment",
          "path, floor and objects could not be brought into agreement",
          "See whether objects stand where they belong; a lost stretch of the path is the usual "
          "cause."};
}

Fact ObjectsFact(const ReportContent& content) {
  if (content.objects.empty()) {
    return {false,
            "Objects",
            "none entered the map",
            "See the detections below: were objects found at all, and were they whole in the "
            "picture, off its border?"};
  }
  std::string unsure;
  std::size_t num_noted = 0;
  for (const ObjectRow& object : content.objects) {
    num_noted += object.note.empty() ? 0 : 1;
    if (object.confidence >= kEvenOdds) continue;
    unsure += (unsure.empty() ? "" : ", ") + object.name;
  }
  Fact fact{unsure.empty(), "Objects", CountInWords(content.objects), {}};
  if (num_noted > 0) fact.finding += fmt::format("; notes on {} of them below", num_noted);
  if (!fact.fine) {
    fact.finding += "; unsure: " + unsure;
    fact.remedy =
        "Compare the outlines in the photographs of these objects below; sides no camera saw are "
        "taken from the chosen model. Walk around such objects to measure them.";
  }
  return fact;
}

Fact PeopleFact(const ReportContent& content) {
  if (!content.looked_for_people) {
    return {false,
            "People",
            "nobody looked for people in the frames: no detector ran",
            "Check the photographs on this page before you pass it on."};
  }
  if (content.num_person_frames == 0) return {true, "People", "no person was seen", {}};
  return {true,
          "People",
          fmt::format("seen in {} frame{}, which this page leaves out",
                      content.num_person_frames,
                      content.num_person_frames == 1 ? "" : "s"),
          {}};
}

Fact SizeFact(const ReportContent& content) {
  const ResultSizes& sizes = content.sizes;
  Fact fact{true, "Size", "map.json takes " + BytesInWords(sizes.map_json), {}};
  if (!content.objects.empty()) {
    fact.finding +=
        fmt::format(", {} an object", BytesInWords(sizes.map_json / content.objects.size()));
  }
  if (sizes.fused_cloud > 0) {
    fact.finding +=
        fmt::format("; the room as a fused point cloud takes {}, {:.0f} times as much",
                    BytesInWords(sizes.fused_cloud),
                    static_cast<double>(sizes.fused_cloud) / static_cast<double>(sizes.map_json));
  }
  return fact;
}

std::string Compared(double winner, double next, std::string_view what, bool more_is_better) {
  constexpr double kNoticeable = 0.005;  // less would be printed as equal percentages
  const double gain = more_is_better ? winner - next : next - winner;
  if (gain < kNoticeable) return {};
  return fmt::format("{} ({:.0f} % against {:.0f} %)", what, 100 * winner, 100 * next);
}

// Why selection passed over a candidate of a higher score (select/select.h).
std::string WhyPassedOver(const CandidateRow& row, int most_views) {
  if (row.is_partial) {
    return "what was made of the measurement agrees with it by nature, but lacks the sides nobody "
           "saw; it wins only where no complete shape agrees";
  }
  if (2 * row.num_views < most_views)
    return fmt::format("could be placed in {} views only, others in {}", row.num_views, most_views);
  return "turns its back to the cameras, as furniture seldom does";
}

// Candidates that agree better with the depth than the winner and lost all the same.
std::string SetAside(const ObjectRow& object, const CandidateRow& winner) {
  int most_views = 0;
  for (const CandidateRow& row : object.candidates)
    most_views = std::max(most_views, row.num_views);
  std::string set_aside;
  for (const CandidateRow& row : object.candidates) {
    if (row.chosen || row.score <= winner.score) continue;
    set_aside += fmt::format("{}{} ({}, {:.3f}): {}",
                             set_aside.empty() ? "" : "; ",
                             row.model,
                             row.source,
                             row.score,
                             WhyPassedOver(row, most_views));
  }
  return set_aside.empty() ? "" : " Set aside in spite of a higher score: " + set_aside + ".";
}

}  // namespace

StatusCounts CountStatus(const std::vector<TrackedFrame>& frames) {
  StatusCounts counts;
  for (const TrackedFrame& frame : frames) {
    switch (frame.status) {
      case TrackingStatus::kTracked:
        ++counts.tracked;
        break;
      case TrackingStatus::kDegenerate:
        ++counts.degenerate;
        break;
      case TrackingStatus::kLost:
        ++counts.lost;
        break;
      case TrackingStatus::kUnreadable:
        ++counts.unreadable;
        break;
    }
  }
  return counts;
}

std::vector<Fact> Facts(const ReportContent& content) {
  std::vector<Fact> facts = {CameraFact(content),
                             FloorFact(content),
                             ObjectsFact(content),
                             GraphFact(content),
                             PeopleFact(content)};
  if (content.sizes.map_json > 0) facts.push_back(SizeFact(content));
  return facts;
}

std::string MeaningOf(const std::string& verdict) {
  if (verdict == "good") {
    return "No check of this run failed. Lines marked \"look\" say what is less sure; compare the "
           "map with the photographs below once, then use it.";
  }
  if (verdict == "doubtful") {
    return "Parts of the map are probably right, but at least one check failed. Look at what is "
           "listed here before you rely on it.";
  }
  if (verdict == "bad")
    return "Do not use this map. Record the room again, or mend what is listed here and run again.";
  return {};
}

std::string WhyItWon(const ObjectRow& object) {
  const auto chosen = std::find_if(object.candidates.begin(),
                                   object.candidates.end(),
                                   [](const CandidateRow& row) { return row.chosen; });
  const auto next = std::find_if(object.candidates.begin(),
                                 object.candidates.end(),
                                 [](const CandidateRow& row) { return !row.chosen; });
  if (chosen == object.candidates.end() || next == object.candidates.end()) return {};
  if (object.note.find("chosen by hand") != std::string::npos)
    return chosen->model + " was chosen by hand.";
  std::string why =
      fmt::format("{} won with a score of {:.3f} of {} candidates; the next in rank has {:.3f}",
                  chosen->model,
                  chosen->score,
                  object.candidates.size(),
                  next->score);
  std::string reasons;
  for (const std::string& reason : {Compared(chosen->surface_share,
                                             next->surface_share,
                                             "more of the measured depth lies on it",
                                             true),
                                    Compared(chosen->coverage_share,
                                             next->coverage_share,
                                             "more of it was confirmed where it should be visible",
                                             true),
                                    Compared(chosen->free_violation,
                                             next->free_violation,
                                             "fewer measurements pass through its solid parts",
                                             false)}) {
    if (reason.empty()) continue;
    reasons += (reasons.empty() ? ": " : ", ") + reason;
  }
  return why + reasons + "." + SetAside(object, *chosen);
}

std::string BytesInWords(std::size_t bytes) {
  const auto number = static_cast<double>(bytes);
  if (bytes < 1000) return fmt::format("{} bytes", bytes);
  if (bytes < 1'000'000) return fmt::format("{:.1f} KB", number / 1e3);
  return fmt::format("{:.1f} MB", number / 1e6);
}

std::string CountInWords(const std::vector<ObjectRow>& objects) {
  std::map<std::string, int> counts;
  for (const ObjectRow& object : objects) ++counts[object.class_name];
  std::vector<std::pair<std::string, int>> sorted(counts.begin(), counts.end());
  std::stable_sort(sorted.begin(), sorted.end(), [](const auto& a, const auto& b) {
    return a.second > b.second;
  });
  std::string words;
  for (const auto& [class_name, count] : sorted)
    words += fmt::format("{}{} x {}", words.empty() ? "" : ", ", count, class_name);
  return words;
}

}  // namespace deepslam::report
