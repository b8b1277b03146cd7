// What the figures of a run mean, in words for people who do not know the method.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "deepslam/report/report_content.h"

namespace deepslam::report {

// Frames by tracking status.
struct StatusCounts {
  int tracked = 0;
  int degenerate = 0;
  int lost = 0;
  int unreadable = 0;
};
[[nodiscard]] StatusCounts CountStatus(const std::vector<TrackedFrame>& frames);

// One line of the overview: what was looked at, what came out, and what to do where it is not fine.
struct Fact {
  bool fine = true;  // nothing to object to
  std::string subject;
  std::string finding;
  std::string remedy;  // empty when fine
};
[[nodiscard]] std::vector<Fact> Facts(const ReportContent& content);

// What "good", "doubtful" or "bad" means and what to do next; one sentence or two.
[[nodiscard]] std::string MeaningOf(const std::string& verdict);

// Why the chosen candidate beat the next one; empty when nothing competed.
[[nodiscard]] std::string WhyItWon(const ObjectRow& object);

// "940 bytes", "4.0 KB", "7.5 MB".
[[nodiscard]] std::string BytesInWords(std::size_t bytes);

// "3 x chair, 1 x table", most first.
[[nodiscard]] std::string CountInWords(const std::vector<ObjectRow>& objects);

}  // namespace deepslam::report
