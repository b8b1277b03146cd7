// `deepslam eval map`: the object map and the fused surface against the truth, and their sizes.
#include <algorithm>
#include <memory>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "deepslam/artifact/json_reader.h"
#include "deepslam/artifact/trajectory_files.h"
#include "deepslam/fuse/choose_frames.h"
#include "deepslam/fuse/tsdf.h"
#include "deepslam/layouts/open_capture.h"
#include "deepslam/storage/store.h"
#include "eval_commands.h"
#include "eval_data.h"
#include "eval_surfaces.h"
#include "number_from.h"

namespace deepslam::tools {
namespace {

namespace fs = std::filesystem;
using artifact::JsonObject;
using artifact::JsonValue;
using Points = std::vector<Eigen::Vector3d>;

constexpr double kBoxMarginM = 0.05;   // the fused surface counts within this of a true box
constexpr double kCloudVoxelM = 0.01;  // of the measured surface that is compared with the truth
constexpr std::int64_t kBytesPerCloudPoint = 15;  // three floats, three bytes of colour

struct EvalMapArguments {
  std::string workspace;
  std::string truth;
  std::string annotation;
  std::string json;
  double threshold_m = 0.05;
  bool skip_cloud = false;
};

bool InBox(const eval::PlacedBox& box, const Eigen::Vector3d& p_world) {
  const Eigen::Vector3d p = box.world_from_object.Inverse() * p_world;
  return (p.cwiseAbs().array() <= 0.5 * box.size_m.array() + kBoxMarginM).all();
}

Result<Points> FusedPoints(const MapResult& map, const Truth& truth) {
  const fs::path file = map.workspace / "fuse" / "room.ply";
  const Result<TriangleMesh> room = ReadPlyMesh(file);
  if (!room.ok()) return room.error();
  if (room->empty()) return Points();
  if (Status status = eval::CheckTriangles(*room, file.string()); !status.ok())
    return status.error();
  Points points =
      eval::SampleSurface(*room, map.trajectory.truth_from_estimate, kAreaPerPointM2, 1);
  DropFloor(points);
  std::erase_if(points, [&](const Eigen::Vector3d& p) {
    return std::none_of(truth.objects.begin(), truth.objects.end(), [&](const TrueObject& object) {
      return InBox(object.box, p);
    });
  });
  return points;
}

// Surface points of the frames that stage `fuse` takes, at 1 cm.
Result<std::int64_t> CountCloudPoints(const fs::path& workspace, const fs::path& capture_folder) {
  const Result<dataset::Capture> capture = layouts::OpenCapture(capture_folder);
  if (!capture.ok()) return capture.error();
  const Result<std::string> frames_json = storage::ReadFile(workspace / "optimize" / "frames.json");
  if (!frames_json.ok()) return frames_json.error();
  const Result<std::string> tum = storage::ReadFile(workspace / "optimize" / "trajectory.tum");
  if (!tum.ok()) return tum.error();
  const auto table = artifact::DecodeTrajectory(
      *frames_json, *tum, (workspace / "optimize" / "frames.json").string());
  if (!table.ok()) return table.error();
  if (static_cast<int>(table->frames.size()) != capture->frames->num_frames())
    return InvalidInput(fmt::format("{}: holds {} frames, the workspace {}: not of one capture",
                                    capture_folder.string(),
                                    capture->frames->num_frames(),
                                    table->frames.size()));
  fuse::FuseOptions options;
  options.truncation_m *= kCloudVoxelM / options.voxel_m;
  options.voxel_m = kCloudVoxelM;
  fuse::TsdfFusion fusion(options);
  for (const FrameIdx idx : fuse::FramesToFuse(table->frames, fuse::FrameChoice())) {
    const TrackedFrame& tracked = table->frames[static_cast<std::size_t>(idx.value)];
    const Result<Frame> frame = capture->frames->Read(idx);
    if (!frame.ok()) continue;  // unusable for the fusion of the run as well
    if (Status status =
            fusion.Integrate(*frame, capture->frames->camera(), tracked.world_from_camera, nullptr);
        !status.ok())
      return status.error();
  }
  return fusion.CountSurfacePoints();
}

void PrintRow(std::string_view name, const eval::SurfaceComparison& surface) {
  fmt::print(stderr,
             "{:<12} {:>12.1f} {:>9.1f} {:>8.1f} {:>15.1f} {:>13.1f}\n",
             name,
             100 * surface.completeness,
             100 * surface.accuracy,
             100 * surface.f_score,
             100 * surface.completeness_m,
             100 * surface.accuracy_m);
}

Result<JsonObject> Sizes(const EvalMapArguments& arguments) {
  JsonObject bytes;
  const fs::path folder = fs::path(arguments.workspace) / "export";
  std::int64_t map_bytes = 0;
  for (const auto& [key, name] : {std::pair("map_json", "map.json"),
                                  std::pair("scene_glb", "scene.glb"),
                                  std::pair("scene_uncompressed_glb", "scene.uncompressed.glb")}) {
    std::error_code code;
    const auto size = fs::file_size(folder / name, code);
    if (code && std::string_view(name) == "map.json")
      return InvalidInput((folder / name).string() + ": missing; let the run reach `export`");
    if (code) continue;
    bytes.emplace(key, static_cast<std::int64_t>(size));
    if (std::string_view(name) == "map.json") map_bytes = static_cast<std::int64_t>(size);
    fmt::print(stderr, "{:<24} {:>12} bytes\n", name, size);
  }
  if (arguments.skip_cloud) return bytes;
  const Result<std::int64_t> points = CountCloudPoints(arguments.workspace, arguments.truth);
  if (!points.ok()) return points.error();
  bytes.emplace("fused_cloud_points", *points);
  bytes.emplace("fused_cloud", *points * kBytesPerCloudPoint);
  const double ratio = static_cast<double>(*points * kBytesPerCloudPoint) /
                       static_cast<double>(std::max<std::int64_t>(1, map_bytes));
  bytes.emplace("fused_cloud_per_map", ratio);
  fmt::print(stderr,
             "{:<24} {:>12} bytes, {:.0f} times map.json\n",
             "fused cloud (1 cm)",
             *points * kBytesPerCloudPoint,
             ratio);
  return bytes;
}

int EvalMap(const EvalMapArguments& arguments) {
  const Result<Truth> truth = ReadTruth(arguments.truth, arguments.annotation);
  if (!truth.ok()) return ReportError(truth.error());
  const Result<MapResult> map = ReadMapResult(arguments.workspace, *truth);
  if (!map.ok()) return ReportError(map.error());
  const Result<Points> fused = FusedPoints(*map, *truth);
  if (!fused.ok()) return ReportError(fused.error());
  const Points true_points = TruePoints(*truth);
  const eval::SurfaceComparison ours =
      eval::CompareSurfaces(MapPoints(*map), true_points, arguments.threshold_m);
  const eval::SurfaceComparison baseline =
      eval::CompareSurfaces(*fused, true_points, arguments.threshold_m);
  fmt::print(stderr,
             "{:<12} {:>12} {:>9} {:>8} {:>15} {:>13}\n",
             fmt::format("at {:.0f} cm", 100 * arguments.threshold_m),
             "complete %",
             "accurate %",
             "F %",
             "completeness cm",
             "accuracy cm");
  PrintRow("object map", ours);
  PrintRow("TSDF", baseline);
  Result<JsonObject> bytes = Sizes(arguments);
  if (!bytes.ok()) return ReportError(bytes.error());
  JsonObject document = artifact::NewDocument("deepslam/eval_map", 1);
  document.emplace("protocol",
                   fmt::format("{}; threshold {} m; outer surface of true objects; floor band {} m "
                               "left out; TSDF within {} m of true boxes",
                               eval::kSurfaceProtocol,
                               arguments.threshold_m,
                               kTrueFloorBandM,
                               kBoxMarginM));
  document.emplace("threshold_m", arguments.threshold_m);
  document.emplace("num_true", static_cast<int>(truth->objects.size()));
  document.emplace("num_mapped", static_cast<int>(map->objects.size()));
  document.emplace("object_map", ToJson(ours));
  document.emplace("tsdf", ToJson(baseline));
  document.emplace("bytes", std::move(bytes).value());
  const Result<std::string> text = DumpJson(std::move(document), "map");
  const Status status = text.ok() ? WriteResult(arguments.json, *text) : Status(text.error());
  return status.ok() ? kExitOk : ReportError(status.error());
}

}  // namespace

void AddEvalMap(CLI::App& eval_command, Command& chosen) {
  auto arguments = std::make_shared<EvalMapArguments>();
  CLI::App* command = eval_command.add_subcommand(
      "map", "Completeness, accuracy and size of the map, beside TSDF fusion of the same frames");
  command->add_option("WORKSPACE", arguments->workspace, "Workspace of a whole run")->required();
  command
      ->add_option("TRUTH",
                   arguments->truth,
                   "The capture, with groundtruth.txt and truth/objects.json or objects.json")
      ->required();
  command->add_option("--annotation", arguments->annotation, "Annotation file in place of TRUTH's");
  command->add_option(
      "--json", arguments->json, "Write the result here instead of to standard output");
  command->add_option("--threshold", arguments->threshold_m, "Of completeness and accuracy, m")
      ->check(NumberFrom(0.001, 1.0))
      ->capture_default_str();
  command->add_flag("--no-cloud",
                    arguments->skip_cloud,
                    "Leave out the size of the fused cloud, for which the frames are fused again");
  command->callback([&chosen, arguments] { chosen = [arguments] { return EvalMap(*arguments); }; });
}

}  // namespace deepslam::tools
