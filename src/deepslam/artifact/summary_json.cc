#include "deepslam/artifact/summary_json.h"

#include <utility>

#include "deepslam/artifact/scene_json.h"

namespace deepslam::artifact {
namespace {

constexpr std::string_view kFormat = "deepslam/optimization";
constexpr int kVersion = 1;

}  // namespace

Result<std::string> EncodeOptimization(const OptimizationRecord& record, std::string_view name) {
  JsonObject document = NewDocument(kFormat, kVersion);
  JsonArray terms;
  for (const EnergyTerm& term : record.summary.terms) {
    JsonObject row;
    row.emplace("name", term.name);
    row.emplace("num_edges", term.num_edges);
    row.emplace("before", term.before);
    row.emplace("after", term.after);
    terms.emplace_back(std::move(row));
  }
  document.emplace("converged", record.summary.converged);
  document.emplace("num_iterations", record.summary.num_iterations);
  document.emplace("message", record.summary.message);
  document.emplace("terms", std::move(terms));
  document.emplace("ground_observed", record.summary.ground_observed);
  document.emplace("ground_world", ToJson(record.ground_world));
  document.emplace("has_ground", record.has_ground);
  return DumpJson(std::move(document), name);
}

Result<OptimizationRecord> DecodeOptimization(TextSource text, std::string_view name) {
  JsonReader reader(std::move(text), name, kFormat, kVersion);
  const JsonNode root = reader.root();
  OptimizationRecord record;
  record.summary.converged = root["converged"].Bool();
  record.summary.num_iterations = root["num_iterations"].Int(0, kMaxId);
  record.summary.message = root["message"].String();
  for (const JsonNode& row : root["terms"].Items()) {
    record.summary.terms.push_back({row["name"].String(),
                                    row["num_edges"].Int(0, kMaxId),
                                    row["before"].Number(),
                                    row["after"].Number()});
  }
  record.summary.ground_observed = root["ground_observed"].Number();
  record.ground_world = ReadPlane(root["ground_world"]);
  record.has_ground = root["has_ground"].Bool();
  return reader.Finish(std::move(record));
}

}  // namespace deepslam::artifact
