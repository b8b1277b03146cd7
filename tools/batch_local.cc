#include "batch_local.h"

#include <chrono>
#include <csignal>
#include <cstring>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "batch_capture.h"
#include "commands.h"
#include "console.h"
#include "deepslam/batch/worker_pool.h"

namespace deepslam::tools {
namespace {

using batch::CaptureRecord;
using batch::CaptureState;

constexpr auto kPollInterval = std::chrono::milliseconds(200);  // a stop signal is seen within it
constexpr auto kStepsInterval = std::chrono::seconds(2);  // batch.json while only steps change

std::string EndOfWorker(const batch::WorkerEvent& event, const std::string& stage) {
  const std::string where = stage.empty() ? std::string() : " in stage " + stage;
  if (event.signal == SIGKILL) {
    return fmt::format(
        "its process was killed{}, most likely because memory ran out; give fewer --jobs", where);
  }
  if (event.signal != 0) {
    return fmt::format("its process crashed{}: {} (signal {})",
                       where,
                       ::strsignal(event.signal),  // NOLINT(concurrency-mt-unsafe)
                       event.signal);
  }
  return fmt::format("its process ended{} with code {}", where, event.exit_code);
}

class LocalEngine {
 public:
  LocalEngine(const batch::BatchFolder& folder,
              const std::vector<std::size_t>& indices,
              const std::function<Status()>& save,
              BatchDisplay& display,
              batch::BatchState& state)
      : folder_(folder),
        indices_(indices),
        save_(save),
        display_(display),
        state_(state),
        pool_("/proc/self/exe", {"batch-worker", folder.root.string()}, state.jobs),
        at_work_(static_cast<std::size_t>(state.jobs)) {}

  Status Run() {
    while (true) {
      if (StopSignalled()) return Stop();
      if (Status status = Assign(); !status.ok()) return status;
      if (num_ended_ == state_.captures.size()) break;
      for (const batch::WorkerEvent& event : pool_.Wait(kPollInterval)) {
        if (Status status = Take(event); !status.ok()) return status;
      }
      if (Status status = SaveSteps(); !status.ok()) return status;
      display_.Update(state_);
    }
    pool_.CloseInputs();
    while (pool_.any_running()) static_cast<void>(pool_.Wait(kPollInterval));
    return Ok();
  }

 private:
  Status Assign() {
    for (std::size_t w = 0; w < at_work_.size(); ++w) {
      if (at_work_[w] || next_ == state_.captures.size()) continue;
      if (Status status = pool_.Send(static_cast<int>(w), std::to_string(indices_[next_]));
          !status.ok())
        return status;
      at_work_[w] = next_;
      CaptureRecord& record = state_.captures[next_++];
      record.state = CaptureState::kRunning;
      record.started_s = static_cast<std::int64_t>(NowSeconds());
      record.process = static_cast<int>(pool_.process(static_cast<int>(w)));
      unsaved_ = true;
    }
    return Ok();
  }

  Status Take(const batch::WorkerEvent& event) {
    std::optional<std::size_t>& at_work = at_work_[static_cast<std::size_t>(event.worker)];
    if (event.ended) return at_work ? TakeEnd(event, *at_work, at_work) : Ok();
    Result<CaptureRecord> record = batch::DecodeRecord(event.line, "answer of a worker");
    if (!record.ok() || !at_work) return Ok();  // its end tells
    CaptureRecord& known = state_.captures[*at_work];
    const bool news = known.stage != record->stage || record->state != CaptureState::kRunning;
    known = std::move(record).value();
    unsaved_ = unsaved_ || news;
    if (known.state == CaptureState::kRunning) return Ok();
    return Ended(known, at_work);
  }

  Status TakeEnd(const batch::WorkerEvent& event,
                 std::size_t index,
                 std::optional<std::size_t>& at_work) {
    CaptureRecord& record = state_.captures[index];
    record.state = stopping_ ? CaptureState::kInterrupted : CaptureState::kFailed;
    record.reason = stopping_ ? Interrupted().message
                              : fmt::format("{}; log: {}",
                                            EndOfWorker(event, record.stage),
                                            folder_.log(record.name).string());
    record.exit_code = stopping_ ? kExitInterrupted : kExitFailed;
    record.process = 0;
    record.ended_s = static_cast<std::int64_t>(NowSeconds());
    if (Status status = WriteRecord(folder_, record); !status.ok()) return status;
    return Ended(record, at_work);
  }

  Status Ended(const CaptureRecord& record, std::optional<std::size_t>& at_work) {
    at_work.reset();
    ++num_ended_;
    display_.Ended(record, num_ended_, state_.captures.size());
    return Save();
  }

  Status Save() {
    unsaved_ = false;
    saved_ = std::chrono::steady_clock::now();
    return save_();
  }

  Status SaveSteps() {
    const bool due = std::chrono::steady_clock::now() - saved_ >= kStepsInterval;
    return due && unsaved_ ? Save() : Ok();
  }

  // Workers leave their stages whole or not at all; a second signal ends this process, and theirs
  // with it.
  Status Stop() {
    stopping_ = true;
    pool_.CloseInputs();
    pool_.SignalAll(SIGTERM);
    while (pool_.any_running()) {
      for (const batch::WorkerEvent& event : pool_.Wait(kPollInterval)) {
        if (Status status = Take(event); !status.ok()) return status;
      }
      display_.Update(state_);
    }
    return Interrupted();
  }

  const batch::BatchFolder& folder_;
  const std::vector<std::size_t>& indices_;
  const std::function<Status()>& save_;
  BatchDisplay& display_;
  batch::BatchState& state_;
  batch::WorkerPool pool_;
  std::vector<std::optional<std::size_t>> at_work_;  // by worker
  std::size_t next_ = 0;
  std::size_t num_ended_ = 0;
  bool stopping_ = false;
  bool unsaved_ = false;
  std::chrono::steady_clock::time_point saved_;
};

}  // namespace

Status RunLocally(const batch::BatchFolder& folder,
                  const std::vector<std::size_t>& indices,
                  const std::function<Status()>& save,
                  BatchDisplay& display,
                  batch::BatchState& state) {
  return LocalEngine(folder, indices, save, display, state).Run();
}

}  // namespace deepslam::tools
