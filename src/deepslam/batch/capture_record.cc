#include "deepslam/batch/capture_record.h"

#include <array>
#include <numeric>
#include <utility>

#include "deepslam/artifact/json_reader.h"
#include "deepslam/batch/record_json.h"

namespace deepslam::batch {
namespace {

using artifact::JsonArray;
using artifact::JsonNode;
using artifact::JsonObject;
using artifact::JsonReader;
using artifact::JsonValue;

constexpr std::string_view kFormat = "deepslam/batch_record";
constexpr int kVersion = 1;  // of the format; raised when its fields change
// Bound of counts and process ids: a record of more is damaged.
constexpr int kManyItems = 1'000'000'000;
constexpr double kLongAgo = 1e12;  // s
constexpr std::array kStates = {CaptureState::kWaiting,
                                CaptureState::kRunning,
                                CaptureState::kDone,
                                CaptureState::kFailed,
                                CaptureState::kInterrupted};

// Messages quote foreign files, which may hold anything.
std::string Utf8(std::string text) {
  if (DumpJson(JsonValue(text), "").ok()) return text;
  for (char& c : text) {
    if (static_cast<unsigned char>(c) >= 0x80) c = '?';
  }
  return text;
}

JsonObject Fields(const CaptureRecord& record) {
  JsonObject row;
  row.emplace("name", record.name);
  row.emplace("capture", record.capture);
  row.emplace("state", NameOf(record.state));
  row.emplace("reason", Utf8(record.reason));
  row.emplace("exit_code", record.exit_code);
  row.emplace("attempts", record.attempts);
  row.emplace("host", record.host);
  row.emplace("process", record.process);
  row.emplace("stage", record.stage);
  row.emplace("stage_done", static_cast<std::int64_t>(record.done));
  row.emplace("stage_total", static_cast<std::int64_t>(record.total));
  row.emplace("started_s", record.started_s);
  row.emplace("ended_s", record.ended_s);
  row.emplace("wall_s", record.wall_s);
  row.emplace("attempt_s", record.attempt_s);
  JsonObject stages;
  for (const auto& [stage, seconds] : record.stage_s) stages.emplace(stage, seconds);
  row.emplace("stage_s", std::move(stages));
  row.emplace("verdict", record.verdict);
  JsonArray reasons;
  for (const std::string& reason : record.verdict_reasons) reasons.emplace_back(Utf8(reason));
  row.emplace("verdict_reasons", std::move(reasons));
  JsonObject objects;
  for (const auto& [class_name, count] : record.objects) objects.emplace(class_name, count);
  row.emplace("objects", std::move(objects));
  row.emplace("num_frames", record.num_frames);
  row.emplace("bytes", record.num_bytes);
  if (record.path_error) {
    JsonObject error;
    error.emplace("rmse_m", record.path_error->ate_rmse_m);
    error.emplace("num_scored", record.path_error->num_scored);
    error.emplace("num_frames", record.path_error->num_frames);
    row.emplace("ate", std::move(error));
  }
  return row;
}

}  // namespace

std::string_view NameOf(CaptureState state) {
  switch (state) {
    case CaptureState::kWaiting:
      return "waiting";
    case CaptureState::kRunning:
      return "running";
    case CaptureState::kDone:
      return "done";
    case CaptureState::kFailed:
      return "failed";
    case CaptureState::kInterrupted:
      break;
  }
  return "interrupted";
}

int NumObjects(const CaptureRecord& record) {
  return std::accumulate(
      record.objects.begin(), record.objects.end(), 0, [](int sum, const auto& entry) {
        return sum + entry.second;
      });
}

JsonValue ToJson(const CaptureRecord& record) { return JsonValue(Fields(record)); }

CaptureRecord ReadRecord(const JsonNode& row) {
  CaptureRecord record;
  record.name = row["name"].String();
  record.capture = row["capture"].String();
  const std::string state = row["state"].String();
  bool known = false;
  for (const CaptureState candidate : kStates) {
    if (NameOf(candidate) != state) continue;
    record.state = candidate;
    known = true;
  }
  if (!known) row["state"].Fail("is no state of a capture");
  record.reason = row["reason"].String();
  record.exit_code = row["exit_code"].Int(0, 255);
  record.attempts = row["attempts"].Int(0, kManyItems);
  record.host = row["host"].String();
  record.process = row["process"].Int(0, kManyItems);
  record.stage = row["stage"].String();
  record.done = static_cast<std::size_t>(row["stage_done"].Int(0, kManyItems));
  record.total = static_cast<std::size_t>(row["stage_total"].Int(0, kManyItems));
  record.started_s = static_cast<std::int64_t>(row["started_s"].Number(0, kLongAgo));
  record.ended_s = static_cast<std::int64_t>(row["ended_s"].Number(0, kLongAgo));
  record.wall_s = row["wall_s"].Number(0, kLongAgo);
  record.attempt_s = row["attempt_s"].Number(0, kLongAgo);
  for (const auto& [stage, seconds] : row["stage_s"].Members())
    record.stage_s[stage] = seconds.Number(0, kLongAgo);
  record.verdict = row["verdict"].String();
  for (const JsonNode& reason : row["verdict_reasons"].Items())
    record.verdict_reasons.push_back(reason.String());
  for (const auto& [class_name, count] : row["objects"].Members())
    record.objects[class_name] = count.Int(0, kManyItems);
  record.num_frames = row["num_frames"].Int(0, kManyItems);
  record.num_bytes = static_cast<std::int64_t>(row["bytes"].Number(0, 1e18));
  if (const JsonNode error = row.Maybe("ate"); error.exists()) {
    record.path_error = PathError{error["rmse_m"].Number(0, 1e9),
                                  error["num_scored"].Int(0, kManyItems),
                                  error["num_frames"].Int(0, kManyItems)};
  }
  return record;
}

Result<std::string> EncodeRecord(const CaptureRecord& record, std::string_view name) {
  JsonObject document = artifact::NewDocument(kFormat, kVersion);
  document.emplace("record", ToJson(record));
  return DumpJson(std::move(document), name);
}

Result<CaptureRecord> DecodeRecord(std::string_view text, std::string_view name) {
  JsonReader reader(text, name, kFormat, kVersion);
  CaptureRecord record = ReadRecord(reader.root()["record"]);
  return reader.Finish(std::move(record));
}

}  // namespace deepslam::batch
