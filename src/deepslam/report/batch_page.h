// The page over all captures of a batch: one self-contained HTML file that links the reports.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "deepslam/report/report_content.h"

namespace deepslam::report {

struct BatchRow {
  std::string name;
  std::string state;        // "done", "failed", "waiting", "running", "interrupted"
  std::string report_link;  // relative, with `/`; empty: there is no report
  std::string log_link;     // relative; empty: none
  Picture thumbnail;        // no bytes: none
  std::string verdict;      // "good", "doubtful", "bad"; empty: none
  std::vector<std::string> verdict_reasons;
  std::string failure;                               // why it failed, and what to do
  std::vector<std::pair<std::string, int>> objects;  // class, number
  int num_frames = 0;
  std::optional<double> ate_m;  // rmse; only where truth exists
  int num_scored = 0;           // frames of the estimate that have a true pose, of num_estimated
  int num_estimated = 0;
  double wall_s = 0;
  double megabytes = 0;  // of the workspace
};

struct BatchPage {
  std::string title;
  std::string tool_version;
  std::string when;  // one line: when it ran, on which engine, how many at a time
  std::vector<BatchRow> rows;
};

// Readable without scripts; with them rows can be sorted and filtered. Texts may hold anything.
[[nodiscard]] std::string RenderBatchPage(const BatchPage& page);

}  // namespace deepslam::report
