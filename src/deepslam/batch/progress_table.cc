#include "deepslam/batch/progress_table.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "deepslam/batch/forecast.h"

namespace deepslam::batch {
namespace {

constexpr int kMaxNameWidth = 32;  // columns: one long name must not widen them for all
// The latest; more push the running captures off the screen.
constexpr std::size_t kMaxFailuresShown = 5;

// One line of at most `width` columns. A cut never leaves half a UTF-8 sequence.
std::string Fitted(std::string text, int width) {
  std::replace(text.begin(), text.end(), '\n', ' ');
  std::size_t columns = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const bool starts = (static_cast<unsigned char>(text[i]) & 0xC0U) != 0x80U;
    if (starts && ++columns > static_cast<std::size_t>(std::max(1, width))) {
      text.resize(i);
      break;
    }
  }
  // Names and reasons come from foreign files: no control sequences into the terminal.
  for (char& c : text) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7F) c = ' ';
  }
  return text;
}

std::string LeftText(std::optional<double> left_s) {
  return left_s ? ", about " + DurationText(*left_s) + " left" : std::string();
}

std::string Headline(const BatchState& batch, double now_s) {
  const StateCounts counts = Count(batch);
  std::string line = fmt::format("{} of {} done", counts.done, batch.captures.size());
  if (counts.failed > 0) line += fmt::format(", {} failed", counts.failed);
  line += fmt::format(", {} running, {} waiting; {}",
                      counts.running,
                      counts.waiting + counts.interrupted,
                      DurationText(now_s - static_cast<double>(batch.started_s)));
  return line + LeftText(SecondsLeft(batch, now_s));
}

std::string RunningLine(const CaptureRecord& record,
                        const std::map<std::string, double>& shares,
                        std::span<const std::string> stages,
                        double now_s,
                        int name_width) {
  const double elapsed_s = now_s - static_cast<double>(record.started_s);
  const std::string steps =
      record.total > 0 ? fmt::format("{}/{}", record.done, record.total) : std::string();
  return fmt::format("  running  {:<{}}  {:<9} {:>9}  {}{}",
                     record.name,
                     name_width,
                     record.stage,
                     steps,
                     DurationText(elapsed_s),
                     LeftText(SecondsLeft(record, elapsed_s, shares, stages)));
}

// The name stands before it: the capture's path need not be said again.
std::string_view ShortReason(const CaptureRecord& record) {
  std::string_view reason = record.reason;
  if (reason.starts_with(record.capture)) reason.remove_prefix(record.capture.size());
  if (reason.starts_with("/") || reason.starts_with(": ")) reason.remove_prefix(1);
  return reason;
}

}  // namespace

std::string DurationText(double seconds) {
  const auto whole = static_cast<std::int64_t>(std::llround(std::max(0.0, seconds)));
  if (whole < 60) return fmt::format("{} s", whole);
  if (whole < 3600) return fmt::format("{} min {:02} s", whole / 60, whole % 60);
  return fmt::format("{} h {:02} min", whole / 3600, whole % 3600 / 60);
}

std::string ObjectsText(const CaptureRecord& record) {
  std::string text;
  for (const auto& [class_name, count] : record.objects)
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", count, class_name);
  return text.empty() ? "no objects" : text;
}

std::string EndLine(const CaptureRecord& record) {
  std::string line = fmt::format("{}: {}", record.name, NameOf(record.state));
  if (record.state != CaptureState::kDone) return line + ": " + record.reason;
  line += fmt::format(" in {:.1f} s", record.attempt_s);
  if (!record.verdict.empty()) line += fmt::format(", {}, {}", record.verdict, ObjectsText(record));
  if (record.path_error) line += fmt::format(", ATE {:.3f} m", record.path_error->ate_rmse_m);
  return line;
}

std::vector<std::string> RenderTable(const BatchState& batch,
                                     std::span<const std::string> stages,
                                     double now_s,
                                     const TableOptions& options) {
  const std::map<std::string, double> shares = StageShares(batch.captures, stages);
  std::vector<const CaptureRecord*> running, failed;
  int name_width = 8;
  for (const CaptureRecord& record : batch.captures) {
    if (record.state == CaptureState::kRunning) {
      running.push_back(&record);
      name_width = std::max(name_width, static_cast<int>(record.name.size()));
    }
    if (record.state == CaptureState::kFailed) failed.push_back(&record);
  }
  name_width = std::min(name_width, kMaxNameWidth);
  // The last failures: those are news.
  std::stable_sort(failed.begin(), failed.end(), [](const auto* a, const auto* b) {
    return a->ended_s < b->ended_s;
  });

  std::vector<std::string> lines = {Fitted(Headline(batch, now_s), options.width)};
  const auto room = static_cast<std::size_t>(std::max(2, options.height - 2));
  for (const CaptureRecord* record : running) {
    if (lines.size() + 1 >= room) {
      lines.push_back(Fitted("  ...", options.width));
      break;
    }
    lines.push_back(Fitted(RunningLine(*record, shares, stages, now_s, name_width), options.width));
  }
  const std::size_t shown =
      std::min({failed.size(), kMaxFailuresShown, room > lines.size() ? room - lines.size() : 0});
  for (std::size_t i = failed.size() - shown; i < failed.size(); ++i) {
    lines.push_back(Fitted(
        fmt::format("  failed   {:<{}}  {}", failed[i]->name, name_width, ShortReason(*failed[i])),
        options.width));
  }
  return lines;
}

}  // namespace deepslam::batch
