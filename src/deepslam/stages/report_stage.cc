// report: the page of a run, and a small picture for lists.
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "deepslam/pipeline/manifest.h"
#include "deepslam/presentation/report_page.h"
#include "deepslam/report/report.h"
#include "deepslam/stages/plan.h"
#include "deepslam/stages/presentation_inputs.h"
#include "deepslam/stages/stage_inputs.h"

namespace deepslam::stages {
namespace {

using pipeline::StageContext;
using pipeline::StageSummary;

// What the stages said of themselves, and the sizes of the files a user takes away.
void AddManifests(const StageContext& context, report::ReportContent& content) {
  for (const std::string& stage : context.inputs()) {
    const std::string name = StageContext::DisplayName(stage, pipeline::kManifestFile);
    const Result<std::string> text = context.Read(stage, pipeline::kManifestFile);
    if (!text.ok()) continue;
    const Result<pipeline::Manifest> manifest = pipeline::DecodeManifest(*text, name);
    if (!manifest.ok()) continue;
    content.stage_summaries.emplace_back(stage, manifest->summary.line);
    const auto figure = [&](const char* figure_name) {
      const auto found = manifest->summary.figures.find(figure_name);
      return found == manifest->summary.figures.end() ? 0 : static_cast<std::size_t>(found->second);
    };
    if (stage != "export") continue;
    content.sizes.map_json = figure("map_bytes");
    content.sizes.scene_glb = figure("scene_bytes");
    content.sizes.objects_glb = figure("objects_glb_bytes");
    for (const auto& [file, output] : manifest->outputs)
      content.file_bytes.emplace_back(file, output.num_bytes);
  }
}

// Null where it cannot be read.
modelling::PreparedModel ReadPrepared(const StageContext& context,
                           const RunInputs& inputs,
                           const ShapeCandidate& candidate,
                           bool chosen) {
  const std::string_view stage = chosen ? "loops" : StageOfModel(candidate.source);
  Result<VoxelGrid> model = ReadModel(context, stage, candidate.model);
  if (!model.ok()) model = ReadModel(context, "loops", candidate.model);  // made, not chosen
  return model.ok() ? inputs.prepared->Prepare(candidate.model, *model) : nullptr;
}

}  // namespace

Result<StageSummary> RunReport(StageContext& context, const RunInputs& inputs) {
  Result<presentation::ReportSources> sources = ReadReportSources(context);
  if (!sources.ok()) return sources.error();
  sources->run = IdentityOf(*inputs.capture);
  sources->capture_warnings = inputs.capture->warnings;
  const presentation::ReportAccess access{
      *inputs.capture->frames,
      [&](const std::set<DetectionId>& wanted) { return ReadSegmentsOf(context, wanted); },
      [&](const ShapeCandidate& candidate, bool chosen) {
        return ReadPrepared(context, inputs, candidate, chosen);
      }};
  Result<presentation::ReportPage> page =
      presentation::MakeReportPage(*sources, access, inputs.classes, context.progress());
  if (!page.ok()) return page.error();
  AddManifests(context, page->content);
  Status status = context.Write("index.html", report::RenderReport(page->content));
  if (status.ok() && !page->thumbnail.bytes.empty())
    status = context.Write("thumbnail.jpg", page->thumbnail.bytes);
  if (!status.ok()) return status.error();
  return StageSummary{
      fmt::format("{}: {} objects", page->content.verdict, page->content.objects.size()), {}};
}

}  // namespace deepslam::stages
