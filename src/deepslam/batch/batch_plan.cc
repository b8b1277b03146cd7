#include "deepslam/batch/batch_plan.h"

#include <utility>

#include "deepslam/artifact/json_reader.h"
#include "deepslam/artifact/json_value.h"

namespace deepslam::batch {
namespace {

constexpr std::string_view kFormat = "deepslam/batch_plan";
constexpr int kVersion = 1;  // of the format; raised when its fields change

}  // namespace

Result<std::string> EncodePlan(const BatchPlan& plan, std::string_view name) {
  artifact::JsonArray captures;
  for (const PlannedCapture& capture : plan.captures) {
    artifact::JsonObject row;
    row.emplace("path", capture.path.string());
    row.emplace("name", capture.name);
    captures.emplace_back(std::move(row));
  }
  artifact::JsonObject document = artifact::NewDocument(kFormat, kVersion);
  document.emplace("captures", std::move(captures));
  document.emplace("run_options", plan.run_options);
  document.emplace("until", plan.until);
  document.emplace("keep_final", plan.keep_final);
  document.emplace("num_threads", plan.num_threads);
  document.emplace("data_folder", plan.data_folder.string());
  return DumpJson(std::move(document), name);
}

Result<BatchPlan> DecodePlan(std::string_view text, std::string_view name) {
  artifact::JsonReader reader(text, name, kFormat, kVersion);
  const artifact::JsonNode root = reader.root();
  BatchPlan plan;
  for (const artifact::JsonNode& row : root["captures"].Items())
    plan.captures.push_back({row["path"].String(), row["name"].String()});
  plan.run_options = root["run_options"].String();
  plan.until = root["until"].String();
  plan.keep_final = root["keep_final"].Bool();
  plan.num_threads = root["num_threads"].Int(0, 1024);
  plan.data_folder = root["data_folder"].String();
  return reader.Finish(std::move(plan));
}

}  // namespace deepslam::batch
