#include "deepslam/artifact/summary_json.h"

#include <utility>

#include "deepslam/artifact/scene_json.h"

namespace deepslam::artifact {

constexpr JsonFormat kFormat{"deepslam/optimization", 1};

void Describe(JsonVisitor& visitor, EnergyTerm& term) {
  visitor.Field("name", term.name);
  visitor.Field("num_edges", term.num_edges);
  visitor.Field("before", term.before);
  visitor.Field("after", term.after);
}

void Describe(JsonVisitor& visitor, OptimizationRecord& record) {
  visitor.Field("converged", record.summary.converged);
  visitor.Field("num_iterations", record.summary.num_iterations);
  visitor.Field("message", record.summary.message);
  visitor.Field("terms", record.summary.terms);
  visitor.Field("ground_observed", record.summary.ground_observed);
  visitor.Field("ground_world", record.ground_world);
  visitor.Field("has_ground", record.has_ground);
}

Result<std::string> EncodeOptimization(const OptimizationRecord& record, std::string_view name) {
  return EncodeDocument(kFormat, record, name);
}

Result<OptimizationRecord> DecodeOptimization(TextSource text, std::string_view name) {
  return DecodeDocument<OptimizationRecord>(kFormat, std::move(text), name);
}

}  // namespace deepslam::artifact
