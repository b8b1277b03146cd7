#include "eval_silhouettes.h"

#include <cstdio>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "commands.h"
#include "console.h"
#include "deepslam/artifact/json_reader.h"
#include "deepslam/artifact/json_value.h"
#include "deepslam/core/progress.h"
#include "deepslam/eval/map_silhouettes.h"
#include "deepslam/eval/silhouette.h"
#include "deepslam/layouts/open_capture.h"
#include "deepslam/pipeline/consistency.h"
#include "deepslam/pipeline/stage.h"
#include "deepslam/stages/stage_inputs.h"

namespace deepslam::tools {
namespace {

// Of a workspace with stages up to `mesh`; InvalidInput where it lacks one or does not fit the
// capture.
Result<eval::SilhouetteReport> CompareSilhouettes(const std::string& workspace,
                                                  const FrameSource& frames) {
  SilentProgress progress;
  const pipeline::StageContext context(
      workspace, {}, {"associate", "loops", "optimize", "mesh"}, progress);
  const Result<OptimizedMap> map = stages::ReadOptimized(context);
  if (!map.ok()) return map.error();
  const Result<Association> association = stages::ReadAssociation(context, "loops");
  if (!association.ok()) return association.error();
  const Result<std::vector<Segment>> segments = stages::ReadSegments(context, "associate");
  if (!segments.ok()) return segments.error();
  std::vector<TriangleMesh> meshes;
  for (const MapObject& object : map->map.objects) {
    Result<TriangleMesh> mesh =
        stages::ReadMesh(context, "mesh", fmt::format("objects/{}.ply", ObjectName(object)));
    if (!mesh.ok()) return mesh.error();
    meshes.push_back(std::move(mesh).value());
  }
  if (Status status = stages::CheckOfThisCapture(map->frames.size(), *segments, frames);
      !status.ok())
    return status.error();
  return eval::CompareSilhouettes({*map, meshes, *association, *segments}, frames, progress);
}

}  // namespace

int EvalSilhouettes(const std::string& workspace,
                    const std::string& capture,
                    const std::string& json_file) {
  if (const Status status = pipeline::CheckConsistency(workspace); !status.ok())
    return ReportError(status.error());
  const Result<dataset::Capture> opened = layouts::OpenCapture(capture);
  if (!opened.ok()) return ReportError(opened.error());
  const Result<eval::SilhouetteReport> report = CompareSilhouettes(workspace, *opened->frames);
  if (!report.ok())
    return ReportError(
        Error{report.error().code, fmt::format("{}: {}", workspace, report.error().message)});
  artifact::JsonArray rows;
  const auto print = [](const std::string& name, std::size_t views, double measured, double all) {
    fmt::print(stderr, "{:<16} {:>6} {:>14.3f} {:>14.3f}\n", name, views, measured, all);
  };
  fmt::print(stderr,
             "{:<16} {:>6} {:>14} {:>14}\n",
             "median IoU of",
             "views",
             "where measured",
             "all pixels");
  for (const eval::ObjectSilhouette& object : report->objects) {
    print(object.name, object.ious.size(), object.median_iou, object.median_iou_all_px);
    artifact::JsonObject row;
    row.emplace("name", object.name);
    row.emplace("class", object.class_name);
    row.emplace("num_views", static_cast<std::int64_t>(object.ious.size()));
    row.emplace("median_iou", object.median_iou);
    row.emplace("median_iou_all_px", object.median_iou_all_px);
    rows.emplace_back(std::move(row));
  }
  print("all",
        static_cast<std::size_t>(report->num_views),
        report->median_iou,
        report->median_iou_all_px);
  artifact::JsonObject document = artifact::NewDocument("deepslam/silhouettes", 1);
  document.emplace("protocol", eval::kSilhouetteProtocol);
  document.emplace("objects", std::move(rows));
  document.emplace("num_views", report->num_views);
  document.emplace("median_iou", report->median_iou);
  document.emplace("median_iou_all_px", report->median_iou_all_px);
  document.emplace("lowest_object_iou", report->lowest_object_iou);
  const Result<std::string> text = DumpJson(std::move(document), "silhouettes");
  const Status status = text.ok() ? WriteResult(json_file, *text) : Status(text.error());
  return status.ok() ? kExitOk : ReportError(status.error());
}

}  // namespace deepslam::tools
