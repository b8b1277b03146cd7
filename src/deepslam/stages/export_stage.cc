// export: the labelled scene, the compact map, the object list.
#include <algorithm>
#include <array>
#include <functional>
#include <iterator>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "deepslam/artifact/map_json.h"
#include "deepslam/artifact/ply.h"
#include "deepslam/core/parallel.h"
#include "deepslam/gltf/scene_writer.h"
#include "deepslam/mesh/check_mesh.h"
#include "deepslam/presentation/compact_map.h"
#include "deepslam/presentation/habitat_pair.h"
#include "deepslam/presentation/labelled_scene.h"
#include "deepslam/presentation/labelled_surface.h"
#include "deepslam/presentation/map_plan.h"
#include "deepslam/presentation/objects_csv.h"
#include "deepslam/presentation/scene_graph.h"
#include "deepslam/presentation/scene_graph_json.h"
#include "deepslam/report/floor_plan.h"
#include "deepslam/report/plan_dxf.h"
#include "deepslam/report/sanity_checks.h"
#include "deepslam/stages/export_elsewhere.h"
#include "deepslam/stages/mesh_options.h"
#include "deepslam/stages/plan.h"
#include "deepslam/stages/presentation_inputs.h"
#include "deepslam/stages/stage_inputs.h"

namespace deepslam::stages {
namespace {

using pipeline::StageContext;
using pipeline::StageSummary;

presentation::SceneOptions SceneOptionsOf(const Config& config) {
  const ExportStageOptions& options = config.export_stage;
  using presentation::Surroundings;
  const Surroundings surroundings = options.surroundings == "layout"     ? Surroundings::kLayout
                                    : options.surroundings == "measured" ? Surroundings::kMeasured
                                                                         : Surroundings::kBoth;
  return {options.appearance != "class",
          options.room,
          options.trajectory,
          config.ground_polygon,
          surroundings};
}

// The scene, its objects alone and, where it is wanted, the uncompressed copy.
std::vector<Result<std::string>> EncodeGlbs(const gltf::GltfScene& scene, const Config& config) {
  std::vector<gltf::GlbKind> kinds = {{config.gltf.draco, false}, {config.gltf.draco, true}};
  if (config.export_stage.uncompressed_copy) kinds.push_back({false, false});
  return gltf::WriteGlbs(scene, config.gltf, kinds);
}

Status WriteOnRequest(StageContext& context,
                      const gltf::GltfScene& scene,
                      const ExportStageOptions& wanted) {
  if (wanted.labelled_ply) {
    presentation::LabelledSurface joined = presentation::JoinSurfaces(scene);
    const Result<std::string> ply =
        artifact::EncodePly({std::move(joined.mesh), {}, std::move(joined.labels)}, "scene.ply");
    if (Status status = WriteEncoded(context, "scene.ply", ply); !status.ok()) return status;
  }
  if (!wanted.habitat) return Ok();
  const Result<presentation::HabitatPair> pair = presentation::EncodeHabitatPair(scene);
  if (!pair.ok()) return pair.error();
  const Status status = context.Write("scene.semantic.glb", pair->glb);
  return status.ok() ? context.Write("scene.semantic.txt", pair->txt) : status;
}

Status WritePlans(StageContext& context,
                  const report::FloorPlanContent& plan,
                  const ExportStageOptions& wanted) {
  const Status status = context.Write("plan.svg", report::FloorPlan(plan));
  if (!status.ok() || !wanted.plan_dxf) return status;
  return context.Write("plan.dxf", report::FloorPlanDxf(plan));
}

StageSummary Summary(const CompactMap& map,
                     const std::vector<Result<std::string>>& glbs,
                     const std::string& map_json) {
  return {fmt::format("{} objects, scene {} bytes (objects {}), map {} bytes, verdict {}",
                      map.objects.size(),
                      glbs[0]->size(),
                      glbs[1]->size(),
                      map_json.size(),
                      NameOf(map.verdict)),
          {{"num_objects", static_cast<double>(map.objects.size())},
           {"scene_bytes", static_cast<double>(glbs[0]->size())},
           {"objects_glb_bytes", static_cast<double>(glbs[1]->size())},
           {"map_bytes", static_cast<double>(map_json.size())}}};
}

}  // namespace

Result<StageSummary> RunExport(StageContext& context, const RunInputs& inputs) {
  const Result<ExportInputs> content = ReadExportInputs(context);
  if (!content.ok()) return content.error();
  const Config& config = inputs.config;
  const presentation::FinishedMap& finished = content->finished;
  const presentation::RunIdentity run = IdentityOf(*inputs.capture);
  const gltf::GltfScene scene = presentation::MakeScene(
      finished, inputs.classes, inputs.capture->frames->camera(), run, SceneOptionsOf(config));
  std::vector<Result<std::string>> glbs;
  CompactMap map;
  std::vector<double> volumes_m3;
  const std::array<std::function<void()>, 2> make = {
      [&] { glbs = EncodeGlbs(scene, config); },
      [&] {
        std::vector<std::string> doubts = inputs.capture->doubts;
        std::ranges::copy(content->doubts, std::back_inserter(doubts));
        const RunVerdict verdict = report::CheckRun(finished.map, content->joins, doubts);
        map = presentation::MakeCompactMap(
            finished, scene, content->codes, {run, verdict, NotedMeshOptions(config)});
        for (const TriangleMesh& mesh : finished.meshes)
          volumes_m3.push_back(mesh::CheckMesh(mesh).volume_m3);
      }};
  ParallelFor(make.size(), [&](std::size_t n) { make[n](); });
  const Result<std::string> map_json = artifact::EncodeMap(map, "map.json");
  for (const Result<std::string>& glb : glbs) {
    if (!glb.ok()) return glb.error();
  }
  Status status = WriteEncoded(context, "scene.glb", glbs[0]);
  if (status.ok() && glbs.size() > 2)
    status = WriteEncoded(context, "scene.uncompressed.glb", glbs[2]);
  if (status.ok()) {
    status = WritePlans(context,
                        presentation::PlanOf(finished, inputs.classes, run.capture_name),
                        config.export_stage);
  }
  if (status.ok()) status = WriteOnRequest(context, scene, config.export_stage);
  if (status.ok()) status = WriteEncoded(context, "map.json", map_json);
  if (status.ok()) {
    status = context.Write("objects.csv", presentation::EncodeObjectsCsv(map.objects, volumes_m3));
  }
  if (status.ok()) {
    const presentation::SceneGraph graph =
        presentation::MakeSceneGraph(map, finished.meshes, volumes_m3, inputs.classes);
    status = WriteEncoded(
        context, "scene_graph.json", presentation::EncodeSceneGraph(graph, "scene_graph.json"));
  }
  if (status.ok()) {
    status = WriteElsewhere(
        {scene, map, finished.meshes, inputs.classes},
        config,
        [&](std::string_view file, std::string_view bytes) { return context.Write(file, bytes); });
  }
  if (!status.ok()) return status.error();
  return Summary(map, glbs, *map_json);
}

}  // namespace deepslam::stages
