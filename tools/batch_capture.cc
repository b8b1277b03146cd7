#include "batch_capture.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdlib>
#include <exception>
#include <new>
#include <set>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "commands.h"
#include "console.h"
#include "deepslam/artifact/map_json.h"
#include "deepslam/artifact/trajectory_files.h"
#include "deepslam/batch/batch_state.h"
#include "deepslam/geometry/trajectory_error.h"
#include "deepslam/storage/store.h"
#include "run_capture.h"

namespace deepslam::tools {
namespace {

namespace fs = std::filesystem;
using batch::CaptureRecord;
using batch::CaptureState;

// Of a finished capture: what a user opens, and the final trajectory with its small tables.
const std::set<std::string> kFinalStages = {"optimize", "export", "report"};
constexpr auto kReportInterval = std::chrono::milliseconds(500);  // each is a line to the batch
constexpr auto kRecordInterval = std::chrono::seconds(3);         // the disk may be a network's

// Standard error of the process goes to a file while the object lives.
class LogFile {
 public:
  explicit LogFile(const fs::path& file) : before_(::fcntl(STDERR_FILENO, F_DUPFD_CLOEXEC, 3)) {
    const int fd = ::open(file.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
    if (fd < 0) return;
    ::dup2(fd, STDERR_FILENO);
    ::close(fd);
  }
  ~LogFile() {
    if (before_ < 0) return;
    ::dup2(before_, STDERR_FILENO);
    ::close(before_);
  }
  LogFile(const LogFile&) = delete;
  LogFile& operator=(const LogFile&) = delete;

 private:
  int before_;
};

// Tells the log what `deepslam run` would tell, and keeps the record up to date.
class RecordListener final : public pipeline::RunListener {
 public:
  RecordListener(CaptureRecord& record, std::function<void()> changed)
      : log_(ProgressStyle::kLines, true), record_(record), changed_(std::move(changed)) {}

  void StageSkipped(std::string_view stage, std::string_view summary) override {
    log_.StageSkipped(stage, summary);
  }
  void StageStarts(std::string_view stage, std::span<const std::string> reasons) override {
    log_.StageStarts(stage, reasons);
    record_.stage = stage;
    record_.done = record_.total = 0;
    Tell();
  }
  void StageDone(std::string_view stage,
                 std::string_view summary,
                 const pipeline::Timing& timing) override {
    log_.StageDone(stage, summary, timing);
  }
  void Report(std::size_t done, std::size_t total) override {
    log_.Report(done, total);
    record_.done = done;
    record_.total = total;
    if (std::chrono::steady_clock::now() - told_ >= kReportInterval) Tell();
  }
  void Warn(std::string_view message) override { log_.Warn(message); }
  [[nodiscard]] bool StopRequested() const override { return StopSignalled(); }

 private:
  void Tell() {
    told_ = std::chrono::steady_clock::now();
    changed_();
  }

  ConsoleListener log_;
  CaptureRecord& record_;
  std::function<void()> changed_;
  std::chrono::steady_clock::time_point told_;
};

// A task of a lost node starts again elsewhere while the old one may not know yet that it is lost.
constexpr int kLostNodePatience_s = 180;

bool WasRequeued() {
  const char* count = std::getenv("SLURM_RESTART_COUNT");  // NOLINT(concurrency-mt-unsafe)
  return count != nullptr && std::string_view(count) != "0";
}

// A cluster may call a node otherwise than the machine calls itself.
std::string HostName() {
  if (const char* node = std::getenv("SLURMD_NODENAME"))
    return node;  // NOLINT(concurrency-mt-unsafe)
  std::array<char, 256> name{};
  if (::gethostname(name.data(), name.size() - 1) != 0) return {};
  return name.data();
}

// Against the poses that came with the capture; nothing where there are none, or too few.
std::optional<batch::PathError> MeasurePath(const CaptureRunResult& result,
                                            const fs::path& workspace) {
  const char* stage = Stands(result.report, "optimize") ? "optimize" : "track";
  const Result<std::string> text = storage::ReadFile(workspace / stage / "trajectory.tum");
  if (!result.capture->has_poses || !text.ok()) return std::nullopt;
  const auto poses = artifact::DecodeTum(*text, "trajectory.tum");
  if (!poses.ok()) return std::nullopt;
  std::vector<TimedPose> estimate, truth;
  for (const artifact::StampedPose& pose : *poses)
    estimate.push_back({pose.time_s, pose.world_from_camera});
  const FrameSource& frames = *result.capture->frames;
  for (int i = 0; i < frames.num_frames(); ++i) {
    if (const auto pose = frames.capture_world_from_camera(FrameIdx{i}))
      truth.push_back({frames.time_s(FrameIdx{i}), *pose});
  }
  const auto error = ComputeTrajectoryError(std::move(estimate), std::move(truth), {});
  if (!error.ok()) return std::nullopt;
  return batch::PathError{error->ate_m.rmse, error->num_scored, error->num_frames};
}

std::int64_t BytesBelow(const fs::path& folder) {
  std::int64_t sum = 0;
  std::error_code error;
  for (fs::recursive_directory_iterator it(folder, error), end; !error && it != end;
       it.increment(error)) {
    std::error_code ignored;
    const auto size = it->is_regular_file(ignored) ? it->file_size(ignored) : 0;
    if (!ignored) sum += static_cast<std::int64_t>(size);
  }
  return sum;
}

void NoteMap(const fs::path& workspace, CaptureRecord& record) {
  const Result<std::string> text = storage::ReadFile(workspace / "export" / "map.json");
  if (!text.ok()) return;
  const Result<CompactMap> map = artifact::DecodeMap(*text, "map.json");
  if (!map.ok()) return;
  record.verdict = NameOf(map->verdict);
  record.verdict_reasons = map->reasons;
  for (const CompactObject& entry : map->objects) ++record.objects[entry.class_name];
}

// What a finished run left, for the table and the page.
void NoteResults(const BatchWork& work,
                 const CaptureRunResult& result,
                 const fs::path& workspace,
                 CaptureRecord& record) {
  record.num_frames = result.capture->frames->num_frames();
  record.stage_s.clear();
  for (const pipeline::StageTiming& timing : result.timings)
    record.stage_s[timing.name] = timing.timing.wall_s;
  if (Stands(result.report, "export")) NoteMap(workspace, record);
  if (work.config.track_stage.poses == "track") record.path_error = MeasurePath(result, workspace);
  record.num_bytes = BytesBelow(workspace);
}

Result<CaptureRunResult> RunCatching(const CaptureRun& run,
                                     const stages::Config& config,
                                     pipeline::RunListener& listener) {
  try {
    return RunCapture(run, config, listener);
  } catch (const std::bad_alloc&) {
    return Failed("out of memory; give fewer --jobs, or run the capture by itself");
  } catch (const std::exception& e) {
    return Failed(fmt::format("a fault of the program: {}", e.what()));
  }
}

// What stays from earlier attempts; the rest is told anew.
CaptureRecord Begin(const CaptureRecord& before, const batch::PlannedCapture& capture) {
  CaptureRecord record;
  record.name = capture.name;
  record.capture = capture.path.string();
  record.state = CaptureState::kRunning;
  record.attempts = before.attempts + 1;
  record.wall_s = before.wall_s;
  record.attempt_s = before.attempt_s;
  record.host = HostName();
  record.process = static_cast<int>(::getpid());
  record.started_s = static_cast<std::int64_t>(NowSeconds());
  return record;
}

void End(const Result<CaptureRunResult>& result, double elapsed_s, CaptureRecord& record) {
  record.process = 0;
  record.ended_s = static_cast<std::int64_t>(NowSeconds());
  const bool worked = !result.ok() || !result->report.ran.empty();
  if (worked || record.attempt_s == 0) {
    record.attempt_s = elapsed_s;
    record.wall_s += elapsed_s;
  }
  if (result.ok()) {
    record.state = CaptureState::kDone;
    record.stage.clear();
    return;
  }
  record.state = result.error().code == ErrorCode::kInterrupted ? CaptureState::kInterrupted
                                                                : CaptureState::kFailed;
  record.reason = result.error().message;
  record.exit_code = ExitCodeOf(result.error().code);
}

}  // namespace

double NowSeconds() {
  return std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
}

Result<BatchWork> ReadWork(const fs::path& root) {
  BatchWork work;
  work.folder = {root};
  const Result<std::string> text = storage::ReadFile(work.folder.plan());
  if (!text.ok()) return text.error();
  Result<batch::BatchPlan> plan = batch::DecodePlan(*text, work.folder.plan().string());
  if (!plan.ok()) return plan.error();
  work.plan = std::move(plan).value();
  Result<stages::Config> config = DecodeRun(work.plan.run_options);
  if (!config.ok()) return config.error();
  work.config = std::move(config).value();
  work.models = std::make_shared<stages::ModelCache>();
  work.hashes = std::make_shared<stages::ContentHashes>();
  return work;
}

Status WritePlan(const batch::BatchFolder& folder, const batch::BatchPlan& plan) {
  for (const fs::path& file : {folder.record("x"), folder.log("x")}) {
    if (Status status = storage::MakeFolders(file.parent_path()); !status.ok()) return status;
  }
  const Result<std::string> text = batch::EncodePlan(plan, "plan.json");
  if (!text.ok()) return text.error();
  return storage::WriteFileAtomically(folder.plan(), *text);
}

CaptureRecord ReadRecordOf(const batch::BatchFolder& folder, const batch::PlannedCapture& capture) {
  const fs::path file = folder.record(capture.name);
  const Result<std::string> text = storage::ReadFile(file);
  if (text.ok()) {
    Result<CaptureRecord> record = batch::DecodeRecord(*text, file.string());
    if (record.ok() && record->name == capture.name) return std::move(record).value();
  }
  CaptureRecord record;
  record.name = capture.name;
  record.capture = capture.path.string();
  return record;
}

Status WriteRecord(const batch::BatchFolder& folder, const CaptureRecord& record) {
  const fs::path file = folder.record(record.name);
  const Result<std::string> text = batch::EncodeRecord(record, file.string());
  if (!text.ok()) return text.error();
  return storage::WriteFileAtomically(file, *text);
}

Result<CaptureRecord> RunPlanned(const BatchWork& work,
                                 std::size_t index,
                                 const std::function<void(const CaptureRecord&)>& changed) {
  const batch::PlannedCapture& planned = work.plan.captures.at(index);
  const LogFile log(work.folder.log(planned.name));
  CaptureRecord record = Begin(ReadRecordOf(work.folder, planned), planned);
  LogInfo(fmt::format("---- {} attempt {}: {}",
                      batch::UtcText(record.started_s),
                      record.attempts,
                      planned.path.string()));
  if (Status status = WriteRecord(work.folder, record); !status.ok()) return status.error();
  changed(record);

  CaptureRun run;
  run.capture = planned.path;
  run.workspace = work.folder.root / planned.name;
  run.data_folder = work.plan.data_folder;
  run.until = work.plan.until;
  run.models = work.models;
  run.hashes = work.hashes;
  run.lock_patience_s = WasRequeued() ? kLostNodePatience_s : 0;
  if (work.plan.keep_final) {
    run.keep = kFinalStages;
    if (!run.until.empty()) run.keep.insert(run.until);
  }
  auto written = std::chrono::steady_clock::now();
  RecordListener listener(record, [&] {
    changed(record);
    // For those who watch from another machine.
    if (std::chrono::steady_clock::now() - written < kRecordInterval) return;
    written = std::chrono::steady_clock::now();
    static_cast<void>(WriteRecord(work.folder, record));
  });
  const auto start = std::chrono::steady_clock::now();
  const Result<CaptureRunResult> result = RunCatching(run, work.config, listener);
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
  End(result, elapsed.count(), record);
  if (result.ok()) {
    NoteResults(work, *result, run.workspace, record);
  } else {
    LogError(record.reason);
  }
  if (Status status = WriteRecord(work.folder, record); !status.ok()) return status.error();
  return record;
}

}  // namespace deepslam::tools
