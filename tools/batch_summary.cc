#include "batch_summary.h"

#include <filesystem>
#include <string>
#include <string_view>

#include <fmt/format.h>

#include "deepslam/report/batch_page.h"
#include "deepslam/storage/store.h"

namespace deepslam::tools {
namespace {

namespace fs = std::filesystem;
using batch::CaptureRecord;
using batch::CaptureState;

void ReplaceAll(std::string& text, std::string_view what, std::string_view with) {
  for (std::size_t at = text.find(what); !what.empty() && at != std::string::npos;
       at = text.find(what, at + with.size())) {
    text.replace(at, what.size(), with);
  }
}

// Pages are passed on: where things lie on this machine is nobody's business.
std::string WithoutPaths(std::string text,
                         const batch::BatchFolder& folder,
                         const CaptureRecord& record) {
  ReplaceAll(text, record.capture + "/", "");
  ReplaceAll(text, folder.root.string() + "/", "");
  const std::string parent = fs::path(record.capture).parent_path().string();
  if (parent.size() > 1) ReplaceAll(text, parent + "/", "");
  return text;
}

report::BatchRow MakeRow(const batch::BatchFolder& folder, const CaptureRecord& record) {
  report::BatchRow row;
  row.name = record.name;
  row.state = NameOf(record.state);
  row.verdict = record.verdict;
  row.verdict_reasons = record.verdict_reasons;
  row.objects = {record.objects.begin(), record.objects.end()};
  row.num_frames = record.num_frames;
  if (record.path_error) {
    row.ate_m = record.path_error->ate_rmse_m;
    row.num_scored = record.path_error->num_scored;
    row.num_estimated = record.path_error->num_frames;
  }
  row.wall_s = record.wall_s;
  row.megabytes = static_cast<double>(record.num_bytes) / 1e6;
  if (record.state == CaptureState::kFailed)
    row.failure = WithoutPaths(record.reason, folder, record);
  std::error_code error;
  if (fs::exists(folder.log(record.name), error))
    row.log_link = ".batch/logs/" + record.name + ".log";
  const fs::path report = folder.root / record.name / "report";
  if (record.state == CaptureState::kDone && fs::exists(report / "index.html", error)) {
    row.report_link = record.name + "/report/index.html";
    if (Result<std::string> bytes = storage::ReadFile(report / "thumbnail.jpg"); bytes.ok())
      row.thumbnail.bytes = std::move(bytes).value();
  }
  return row;
}

std::string When(const batch::BatchState& state) {
  std::string text = "started " + batch::UtcText(state.started_s);
  if (state.ended_s > 0) text += ", ended " + batch::UtcText(state.ended_s);
  text += ", " + state.state;
  if (state.engine == "slurm") return text + ", on Slurm";
  return text + fmt::format(", {} at a time", state.jobs);
}

}  // namespace

Status WriteBatchFile(const batch::BatchFolder& folder, const batch::BatchState& state) {
  const Result<std::string> text = batch::EncodeBatch(state, "batch.json");
  if (!text.ok()) return text.error();
  return storage::WriteFileAtomically(folder.batch_json(), *text);
}

Status WriteBatchPage(const batch::BatchFolder& folder, const batch::BatchState& state) {
  report::BatchPage page;
  page.title = folder.root.filename().string();
  page.tool_version = state.tool_version;
  page.when = When(state);
  for (const CaptureRecord& record : state.captures) page.rows.push_back(MakeRow(folder, record));
  return storage::WriteFileAtomically(folder.page(), report::RenderBatchPage(page));
}

}  // namespace deepslam::tools
