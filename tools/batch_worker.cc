// A worker of `deepslam batch`: takes numbers of captures on standard input, answers with records
// on standard output. Not for people: no help lists it.
#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "batch_capture.h"
#include "batch_display.h"
#include "batch_local.h"
#include "commands.h"
#include "console.h"
#include "deepslam/core/parallel.h"

namespace deepslam::tools {
namespace {

// Lines of standard input. Ends at its end, and when the user asked to stop.
class LineReader {
 public:
  std::optional<std::string> Next() {
    while (true) {
      if (const std::size_t end = unread_.find('\n'); end != std::string::npos) {
        std::string line = unread_.substr(0, end);
        unread_.erase(0, end + 1);
        return line;
      }
      char buffer[256];
      const ssize_t got = StopSignalled() ? 0 : ::read(STDIN_FILENO, buffer, sizeof(buffer));
      if (got == 0 || (got < 0 && errno != EINTR)) return std::nullopt;
      if (got > 0) unread_.append(buffer, static_cast<std::size_t>(got));
    }
  }

 private:
  std::string unread_;
};

// One record, one line. What libraries print to standard output must not come between: it goes
// where the log goes.
class RecordWriter {
 public:
  RecordWriter() : fd_(::fcntl(STDOUT_FILENO, F_DUPFD_CLOEXEC, 3)) {
    ::dup2(STDERR_FILENO, STDOUT_FILENO);
  }
  ~RecordWriter() {
    if (fd_ >= 0) ::close(fd_);
  }
  RecordWriter(const RecordWriter&) = delete;
  RecordWriter& operator=(const RecordWriter&) = delete;

  void Write(const batch::CaptureRecord& record) const {
    Result<std::string> text = batch::EncodeRecord(record, "record");
    if (!text.ok()) return;
    std::replace(text->begin(), text->end(), '\n', ' ');
    *text += '\n';
    std::string_view left = *text;
    while (!left.empty()) {
      const ssize_t written = ::write(fd_, left.data(), left.size());
      if (written < 0 && errno == EINTR) continue;
      if (written < 0) return;  // nobody listens any more: the record's file says it all
      left.remove_prefix(static_cast<std::size_t>(written));
    }
  }

 private:
  int fd_;
};

int Work(const std::string& root) {
  CatchStopSignals();
  const Result<BatchWork> work = ReadWork(root);
  if (!work.ok()) return ReportError(work.error());
  const ThreadLimit limit(work->plan.num_threads);
  const RecordWriter writer;
  LineReader lines;
  while (const std::optional<std::string> line = lines.Next()) {
    std::size_t index = 0;
    const auto parsed = std::from_chars(line->data(), line->data() + line->size(), index);
    if (parsed.ec != std::errc() || index >= work->plan.captures.size())
      return ReportError(Failed(fmt::format("'{}' is no capture of the batch", *line)));
    const Result<batch::CaptureRecord> record = RunPlanned(
        *work, index, [&](const batch::CaptureRecord& changed) { writer.Write(changed); });
    if (!record.ok()) return ReportError(record.error());
    writer.Write(*record);
  }
  return StopSignalled() ? kExitInterrupted : kExitOk;
}

// A task of a cluster: some captures, one after another, each in a process that may die without
// taking the rest of them with it.
int WorkOnTask(const std::string& root, std::size_t task, std::size_t per_task) {
  CatchStopSignals();
  const Result<BatchWork> work = ReadWork(root);
  if (!work.ok()) return ReportError(work.error());
  batch::BatchState state;
  std::vector<std::size_t> indices;
  const std::size_t end = std::min(work->plan.captures.size(), (task + 1) * per_task);
  for (std::size_t i = task * per_task; i < end; ++i) {
    indices.push_back(i);
    state.captures.push_back(ReadRecordOf(work->folder, work->plan.captures[i]));
  }
  BatchDisplay display(BatchStyle::kLines, {});
  const Status outcome = RunLocally(
      work->folder, indices, [] { return Ok(); }, display, state);
  return outcome.ok() ? ExitCode(state) : ReportError(outcome.error());
}

}  // namespace

void AddBatchWorker(CLI::App& app, Command& chosen) {
  struct Arguments {
    std::string root;
    int task = -1;
    int per_task = 1;
  };
  auto arguments = std::make_shared<Arguments>();
  CLI::App* worker = app.add_subcommand("batch-worker", "A worker of `deepslam batch`");
  worker->group("");
  worker->add_option("ROOT", arguments->root, "Folder of the batch")->required();
  worker->add_option("--task", arguments->task, "Number of the task")
      ->check(CLI::Range(0, 1'000'000));
  worker->add_option("--per-task", arguments->per_task, "Captures of a task")
      ->check(CLI::Range(1, 1'000'000));
  worker->callback([&chosen, arguments] {
    chosen = [arguments] {
      return arguments->task < 0 ? Work(arguments->root)
                                 : WorkOnTask(arguments->root,
                                              static_cast<std::size_t>(arguments->task),
                                              static_cast<std::size_t>(arguments->per_task));
    };
  });
}

}  // namespace deepslam::tools
