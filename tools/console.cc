#include "console.h"

#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdio>

#include <fmt/format.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include "deepslam/artifact/json_value.h"

namespace deepslam::tools {
namespace {

constexpr int kMaxWarningsPerStage = 10;                       // more are only counted
constexpr int kBarWidth = 30;                                  // characters
constexpr auto kBarInterval = std::chrono::milliseconds(100);  // of redrawing
constexpr auto kLineInterval = std::chrono::seconds(10);  // of lines where there is no terminal

// A signal handler may touch nothing else.
volatile std::sig_atomic_t stop_signalled = 0;

extern "C" void OnStopSignal(int) { stop_signalled = 1; }

}  // namespace

void SetUpLogging(const std::string& level) {
  auto logger = spdlog::stderr_color_mt("deepslam");
  logger->set_pattern("%^%l%$: %v");
  logger->set_level(spdlog::level::from_str(level == "warning" ? "warn" : level));
  spdlog::set_default_logger(logger);
}

void LogInfo(std::string_view line) { spdlog::info("{}", line); }
void LogWarning(std::string_view line) { spdlog::warn("{}", line); }
void LogError(std::string_view line) { spdlog::error("{}", line); }

void CatchStopSignals() {
  struct sigaction action {};
  action.sa_handler = OnStopSignal;
  action.sa_flags = static_cast<int>(SA_RESETHAND);
  ::sigaction(SIGINT, &action, nullptr);
  ::sigaction(SIGTERM, &action, nullptr);
}

void TurnFileSizeSignalIntoError() { std::signal(SIGXFSZ, SIG_IGN); }

bool StopSignalled() { return stop_signalled != 0; }

ProgressStyle ParseProgressStyle(std::string_view name) {
  if (name == "bar") return ProgressStyle::kBar;
  if (name == "json") return ProgressStyle::kJson;
  if (name == "none") return ProgressStyle::kNone;
  return ::isatty(STDERR_FILENO) != 0 ? ProgressStyle::kBar : ProgressStyle::kLines;
}

ConsoleListener::ConsoleListener(ProgressStyle style, bool explain)
    : style_(style), explain_(explain) {}

void ConsoleListener::StageSkipped(std::string_view stage, std::string_view summary) {
  if (style_ == ProgressStyle::kJson) {
    stage_ = stage;
    return Event("skipped", summary);
  }
  if (style_ == ProgressStyle::kNone && !explain_) return;
  LogInfo(fmt::format("{:<9} unchanged: {}", stage, summary));
}

void ConsoleListener::StageStarts(std::string_view stage, std::span<const std::string> reasons) {
  stage_ = stage;
  num_warnings_ = 0;
  last_report_ = {};
  std::string why;
  for (const std::string& reason : reasons) why += (why.empty() ? "" : "; ") + reason;
  if (style_ == ProgressStyle::kJson) return Event("start", why);
  if (explain_) LogInfo(fmt::format("{:<9} runs: {}", stage, why));
}

void ConsoleListener::StageDone(std::string_view stage,
                                std::string_view summary,
                                const pipeline::Timing& timing) {
  ClearBar();
  if (num_warnings_ > kMaxWarningsPerStage) {
    LogWarning(fmt::format("{}: {} more warnings", stage, num_warnings_ - kMaxWarningsPerStage));
  }
  if (style_ == ProgressStyle::kJson) return Event("done", summary);
  if (style_ == ProgressStyle::kNone && !explain_) return;
  const std::string memory = timing.peak_memory_mib > 0
                                 ? fmt::format(", {:4.0f} MiB", timing.peak_memory_mib)
                                 : std::string();
  LogInfo(fmt::format("{:<9} {:6.1f} s{}: {}", stage, timing.wall_s, memory, summary));
}

void ConsoleListener::Report(std::size_t done, std::size_t total) {
  if (style_ == ProgressStyle::kNone || total == 0) return;
  const auto now = std::chrono::steady_clock::now();
  const bool bar = style_ == ProgressStyle::kBar;
  if (last_report_ == std::chrono::steady_clock::time_point()) {
    last_report_ = bar ? now - kBarInterval : now;
  }
  if (now - last_report_ <
      (bar ? std::chrono::steady_clock::duration(kBarInterval) : kLineInterval))
    return;
  last_report_ = now;
  done = std::min(done, total);
  if (style_ == ProgressStyle::kJson) return Event("progress", fmt::format("{}/{}", done, total));
  if (!bar) return LogInfo(fmt::format("{:<9} {} of {}", stage_, done, total));
  const std::size_t filled = kBarWidth * done / total;
  fmt::print(stderr,
             "\r{:<9} [{}{}] {}/{} ",
             stage_,
             std::string(filled, '#'),
             std::string(kBarWidth - filled, '.'),
             done,
             total);
  std::fflush(stderr);
  bar_shown_ = true;
}

void ConsoleListener::Warn(std::string_view message) {
  if (++num_warnings_ > kMaxWarningsPerStage) return;
  ClearBar();
  LogWarning(fmt::format("{}: {}", stage_, message));
}

void ConsoleListener::ClearBar() {
  if (!bar_shown_) return;
  fmt::print(stderr, "\r\033[K");
  std::fflush(stderr);
  bar_shown_ = false;
}

void ConsoleListener::Event(std::string_view event, std::string_view text) {
  artifact::JsonObject object;
  object.emplace("event", event);
  object.emplace("stage", stage_);
  object.emplace("text", text);
  Result<std::string> line = DumpJson(std::move(object), "progress");
  if (!line.ok()) return;
  std::replace(line->begin(), line->end() - 1, '\n', ' ');  // one event, one line
  fmt::print(stderr, "{}", *line);
}

}  // namespace deepslam::tools
