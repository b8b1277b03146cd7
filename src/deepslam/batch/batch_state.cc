#include "deepslam/batch/batch_state.h"

#include <ctime>
#include <utility>

#include "deepslam/artifact/json_reader.h"
#include "deepslam/batch/record_json.h"

namespace deepslam::batch {
namespace {

using artifact::JsonArray;
using artifact::JsonNode;
using artifact::JsonObject;
using artifact::JsonReader;

constexpr std::string_view kFormat = "deepslam/batch";
constexpr int kVersion = 1;  // of the format; raised when its fields change

}  // namespace

StateCounts Count(const BatchState& batch) {
  StateCounts counts;
  for (const CaptureRecord& record : batch.captures) {
    switch (record.state) {
      case CaptureState::kWaiting:
        ++counts.waiting;
        break;
      case CaptureState::kRunning:
        ++counts.running;
        break;
      case CaptureState::kDone:
        ++counts.done;
        break;
      case CaptureState::kFailed:
        ++counts.failed;
        break;
      case CaptureState::kInterrupted:
        ++counts.interrupted;
        break;
    }
  }
  return counts;
}

int ExitCode(const BatchState& batch) {
  const StateCounts counts = Count(batch);
  if (counts.waiting + counts.running + counts.interrupted > 0) return 130;
  return counts.failed > 0 ? 1 : 0;
}

std::string UtcText(std::int64_t seconds) {
  if (seconds <= 0) return "";
  const std::time_t time = seconds;
  std::tm parts{};
  char text[32] = {};
  if (::gmtime_r(&time, &parts) == nullptr) return "";
  std::strftime(text, sizeof(text), "%Y-%m-%dT%H:%M:%SZ", &parts);
  return text;
}

Result<std::string> EncodeBatch(const BatchState& batch, std::string_view name) {
  JsonObject document = artifact::NewDocument(kFormat, kVersion);
  document.emplace("tool_version", batch.tool_version);
  document.emplace("state", batch.state);
  document.emplace("engine", batch.engine);
  document.emplace("jobs", batch.jobs);
  document.emplace("started", UtcText(batch.started_s));
  document.emplace("started_s", batch.started_s);
  document.emplace("ended", UtcText(batch.ended_s));
  document.emplace("ended_s", batch.ended_s);
  const StateCounts counts = Count(batch);
  JsonObject numbers;
  numbers.emplace("all", static_cast<std::int64_t>(batch.captures.size()));
  numbers.emplace("waiting", counts.waiting);
  numbers.emplace("running", counts.running);
  numbers.emplace("done", counts.done);
  numbers.emplace("failed", counts.failed);
  numbers.emplace("interrupted", counts.interrupted);
  document.emplace("counts", std::move(numbers));
  JsonArray captures;
  for (const CaptureRecord& record : batch.captures) captures.push_back(ToJson(record));
  document.emplace("captures", std::move(captures));
  return DumpJson(std::move(document), name);
}

Result<BatchState> DecodeBatch(std::string_view text, std::string_view name) {
  JsonReader reader(text, name, kFormat, kVersion);
  const JsonNode root = reader.root();
  BatchState batch;
  batch.tool_version = root["tool_version"].String();
  batch.state = root["state"].String();
  batch.engine = root["engine"].String();
  batch.jobs = root["jobs"].Int(0, 1'000'000);
  batch.started_s = static_cast<std::int64_t>(root["started_s"].Number(0, 1e12));
  batch.ended_s = static_cast<std::int64_t>(root["ended_s"].Number(0, 1e12));
  for (const JsonNode& row : root["captures"].Items()) batch.captures.push_back(ReadRecord(row));
  return reader.Finish(std::move(batch));
}

}  // namespace deepslam::batch
