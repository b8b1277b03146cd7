#include "eval_data.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <Eigen/Geometry>

#include "console.h"
#include "deepslam/artifact/json_reader.h"
#include "deepslam/artifact/objects_json.h"
#include "deepslam/artifact/ply.h"
#include "deepslam/artifact/trajectory_files.h"
#include "deepslam/dataset/capture_settings.h"
#include "deepslam/dataset/image_files.h"
#include "deepslam/formats/tum_lists.h"
#include "deepslam/geometry/box.h"
#include "deepslam/pipeline/consistency.h"
#include "deepslam/shape/binvox.h"
#include "deepslam/shape/voxelize.h"
#include "deepslam/stages/stage_inputs.h"
#include "deepslam/storage/store.h"

namespace deepslam::tools {
namespace {

namespace fs = std::filesystem;
using artifact::JsonNode;
using artifact::JsonObject;
using artifact::JsonReader;

constexpr double kMaxBoxM = 50;      // larger boxes are refused: not in metres
constexpr double kMaxPlaceM = 1000;  // and so is what lies farther from the origin

TriangleMesh BoxMesh(const Eigen::Vector3d& size_m) {
  TriangleMesh mesh;
  for (int n = 0; n < 8; ++n) {
    const Eigen::Vector3d side(
        (n & 4) != 0 ? 0.5 : -0.5, (n & 2) != 0 ? 0.5 : -0.5, (n & 1) != 0 ? 0.5 : -0.5);
    mesh.vertices.push_back(size_m.cwiseProduct(side).cast<float>());
  }
  constexpr std::array<std::array<std::uint32_t, 4>, 6> kSides = {
      {{0, 1, 3, 2}, {4, 6, 7, 5}, {0, 4, 5, 1}, {2, 3, 7, 6}, {0, 2, 6, 4}, {1, 5, 7, 3}}};
  for (const auto& side : kSides) {
    mesh.faces.push_back({side[0], side[1], side[2]});
    mesh.faces.push_back({side[0], side[2], side[3]});
  }
  return mesh;
}

Eigen::Vector3d ReadVector(const JsonNode& node, double min, double max) {
  Eigen::Vector3d value = Eigen::Vector3d::Zero();
  const std::vector<JsonNode> items = node.Items(3);
  for (std::size_t n = 0; n < 3; ++n)
    value[static_cast<Eigen::Index>(n)] = items[n].Number(min, max);
  return value;
}

Eigen::Quaterniond ReadRotation(const JsonNode& node) {
  const std::vector<JsonNode> items = node.Items(4);
  Eigen::Quaterniond q(items[3].Number(-1.1, 1.1),
                       items[0].Number(-1.1, 1.1),
                       items[1].Number(-1.1, 1.1),
                       items[2].Number(-1.1, 1.1));
  if (std::abs(q.norm() - 1) > 1e-3) node.Fail("is no unit quaternion");
  return q.norm() > 0 ? q.normalized() : Eigen::Quaterniond::Identity();
}

// Box and pose of an entry, in the words of rendered truth or of annotations.
eval::PlacedBox ReadBox(const JsonNode& node) {
  eval::PlacedBox box;
  box.class_name = node["class"].String();
  if (node.Maybe("half_extent_m").exists()) {
    box.size_m = 2 * ReadVector(node["half_extent_m"], 1e-4, kMaxBoxM);
    box.world_from_object.translation_m = ReadVector(node["center_m"], -kMaxPlaceM, kMaxPlaceM);
    box.world_from_object.rotation = Eigen::Quaterniond(
        Eigen::AngleAxisd(node["yaw_rad"].Number(-10, 10), Eigen::Vector3d::UnitZ()));
    return box;
  }
  box.size_m = ReadVector(node["size_m"], 1e-4, kMaxBoxM);
  box.world_from_object.translation_m = ReadVector(node["translation_m"], -kMaxPlaceM, kMaxPlaceM);
  box.world_from_object.rotation = ReadRotation(node["rotation_xyzw"]);
  return box;
}

// A round thing's turn says nothing. Other turns are not forgiven by their mean distance: of a
// cabinet's surface the handles, which tell its front, are little.
shape::Symmetry SymmetryOf(const TrueObject& object) {
  constexpr double kRound_m = 0.01;  // mean distance of surfaces that count as one
  const shape::ShapeModel model(object.grid);
  const double scale_m = object.box.size_m.maxCoeff() / kModelExtent;
  return shape::IsRound(model, scale_m, kRound_m) ? shape::Symmetry::kAny
                                                  : shape::SymmetryOf(model);
}

Status FillShape(const fs::path& mesh_file, TrueObject& object) {
  object.mesh = BoxMesh(object.box.size_m);
  if (!mesh_file.empty()) {
    Result<TriangleMesh> mesh = ReadPlyMesh(mesh_file);
    if (!mesh.ok()) return mesh.error();
    object.mesh = std::move(mesh).value();
    object.has_shape = true;
  }
  if (Status status = eval::CheckTriangles(object.mesh, mesh_file.string()); !status.ok())
    return status;
  Result<VoxelGrid> grid = shape::Voxelize(object.mesh);
  if (!grid.ok()) return InvalidInput(mesh_file.string() + ": " + grid.error().message);
  object.grid = std::move(grid).value();
  object.symmetry = SymmetryOf(object);
  return Ok();
}

Result<std::vector<TrueObject>> ReadObjects(const fs::path& file) {
  const Result<std::string> text = storage::ReadFile(file);
  if (!text.ok()) return text.error();
  JsonReader reader(*text, file.string(), "", 0);
  std::vector<TrueObject> objects;
  std::vector<std::string> meshes;
  for (const JsonNode& node : reader.root()["objects"].Items()) {
    TrueObject object;
    object.box = ReadBox(node);
    object.number = static_cast<int>(objects.size()) + 1;
    objects.push_back(std::move(object));
    const JsonNode mesh = node.Maybe("mesh");
    meshes.push_back(mesh.exists() ? mesh.String() : std::string());
    if (fs::path(meshes.back()).is_absolute() || meshes.back().find("..") != std::string::npos)
      mesh.Fail("must be a file beside this one");
  }
  if (!reader.ok()) return reader.error();
  for (std::size_t i = 0; i < objects.size(); ++i) {
    const fs::path mesh = meshes[i].empty() ? fs::path() : file.parent_path() / meshes[i];
    if (Status status = FillShape(mesh, objects[i]); !status.ok()) return status.error();
  }
  return objects;
}

Result<PinholeCamera> CameraOf(const fs::path& capture) {
  const fs::path file = capture / "capture.yaml";
  const Result<std::string> text = storage::ReadFile(file);
  if (!text.ok()) return text.error();
  const Result<dataset::CaptureSettings> settings = dataset::ParseCaptureSettings(*text, file);
  if (!settings.ok()) return settings.error();
  return settings->camera;
}

// Most pixels of each object in one frame, by the instance masks.
Status CountVisible(const fs::path& capture, Truth& truth) {
  const fs::path folder = capture / "truth" / "instances";
  std::error_code code;
  std::vector<fs::path> files;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, code)) {
    if (entry.path().extension() == ".png") files.push_back(entry.path());
  }
  if (files.empty()) return Ok();
  std::sort(files.begin(), files.end());
  const Result<PinholeCamera> camera = CameraOf(capture);
  if (!camera.ok()) return camera.error();
  std::vector<int> most(truth.objects.size() + 1, 0);
  for (const fs::path& file : files) {
    const auto image = dataset::ReadDepthFile(file, camera->width, camera->height);
    if (!image.ok()) return InvalidInput("instance mask " + image.error().message);
    std::vector<int> count(most.size(), 0);
    for (const std::uint16_t value : *image) {
      if (value > truth.objects.size())
        return InvalidInput(
            fmt::format("{}: names object {} of {}: masks and objects.json are not "
                        "of one capture",
                        file.string(),
                        value,
                        truth.objects.size()));
      ++count[value];
    }
    for (std::size_t n = 0; n < most.size(); ++n) most[n] = std::max(most[n], count[n]);
  }
  for (std::size_t n = 0; n < truth.objects.size(); ++n) truth.objects[n].visible_px = most[n + 1];
  const auto unseen = std::erase_if(truth.objects, [&](const TrueObject& object) {
    return object.visible_px < kVisibleShare * camera->width * camera->height;
  });
  truth.num_unseen = static_cast<int>(unseen);
  return Ok();
}

Result<fs::path> TruthFile(const fs::path& capture, const std::string& annotation) {
  if (!annotation.empty()) return fs::path(annotation);
  std::error_code code;
  for (const fs::path& file : {capture / "truth" / "objects.json", capture / "objects.json"}) {
    if (fs::exists(file, code)) return file;
  }
  return InvalidInput(capture.string() +
                      ": no truth there, neither truth/objects.json nor objects.json; name an "
                      "annotation file with --annotation");
}

Result<MappedObject> ReadMapped(const fs::path& workspace,
                                const MapObject& object,
                                const Pose3& truth_from_map) {
  MappedObject mapped;
  mapped.object = object;
  mapped.name = ObjectName(object);
  const fs::path mesh_file = workspace / "mesh" / "objects" / (mapped.name + ".ply");
  Result<TriangleMesh> mesh = ReadPlyMesh(mesh_file);
  if (!mesh.ok()) return mesh.error();
  if (Status status = eval::CheckTriangles(*mesh, mesh_file.string()); !status.ok())
    return status.error();
  mapped.mesh = std::move(mesh).value();
  Result<VoxelGrid> grid = ReadGrid(workspace / "loops" / "models" / (object.model + ".binvox"));
  if (!grid.ok()) return grid.error();
  mapped.grid = std::move(grid).value();
  mapped.true_world_from_object = truth_from_map * object.world_from_object;
  Box3 box;
  for (const Eigen::Vector3f& vertex : mapped.mesh.vertices) box.Extend(vertex.cast<double>());
  mapped.box = {
      object.class_name,
      {mapped.true_world_from_object.rotation, mapped.true_world_from_object * box.Center()},
      box.Size()};
  return mapped;
}

// The truth of another capture lies elsewhere along the way, and what is scored by it looks like a
// poor map.
void WarnOfForeignTruth(const fs::path& workspace,
                        const std::vector<TimedPose>& path,
                        const fs::path& capture,
                        double ate_m) {
  constexpr double kMaxShare = 0.1;  // of the path's extent: one that is not lost keeps far below
  Eigen::AlignedBox3d extent;
  for (const TimedPose& pose : path) extent.extend(pose.world_from_camera.translation_m);
  if (ate_m <= kMaxShare * extent.diagonal().norm()) return;
  LogWarning(
      fmt::format("the path of {} is {:.2f} m off that of {}: it is lost, or this is the truth of "
                  "another capture",
                  workspace.string(),
                  ate_m,
                  capture.string()));
}

}  // namespace

Result<std::vector<TimedPose>> ReadTum(const fs::path& file) {
  const Result<std::string> text = storage::ReadFile(file);
  if (!text.ok()) return text.error();
  const auto decoded = artifact::DecodeTum(*text, file.string());
  if (!decoded.ok()) return decoded.error();
  std::vector<TimedPose> poses;
  for (const artifact::StampedPose& pose : *decoded)
    poses.push_back({pose.time_s, pose.world_from_camera});
  return poses;
}

Result<std::vector<TimedPose>> ReadCaptureTum(const fs::path& file) {
  Result<std::vector<TimedPose>> strict = ReadTum(file);
  if (strict.ok()) return strict;
  const Result<std::string> text = storage::ReadFile(file);
  if (!text.ok()) return text.error();
  std::vector<std::string> warnings;
  const Result<std::vector<formats::TimedPose>> parsed = formats::ParsePoses(*text, file, warnings);
  if (!parsed.ok()) return parsed.error();
  for (const std::string& warning : warnings) LogWarning(warning);
  std::vector<TimedPose> poses;
  for (const formats::TimedPose& pose : *parsed)
    poses.push_back({pose.time_s, pose.world_from_camera});
  return poses;
}

Result<VoxelGrid> ReadGrid(const fs::path& file) {
  const Result<std::string> bytes = storage::ReadFile(file);
  if (!bytes.ok()) return bytes.error();
  Result<VoxelGrid> grid = shape::ReadBinvox(*bytes);
  if (!grid.ok()) return InvalidInput(file.string() + ": " + grid.error().message);
  return grid;
}

Result<TriangleMesh> ReadPlyMesh(const fs::path& file) {
  const Result<std::string> bytes = storage::ReadFile(file);
  if (!bytes.ok()) return bytes.error();
  Result<artifact::PlyMesh> ply = artifact::DecodePly(*bytes, file.string());
  if (!ply.ok()) return ply.error();
  return std::move(ply->mesh);
}

Result<Truth> ReadTruth(const fs::path& capture,
                        const std::string& annotation,
                        bool objects_wanted) {
  Truth truth;
  truth.capture = capture;
  Result<std::vector<TimedPose>> poses = ReadCaptureTum(capture / "groundtruth.txt");
  if (!poses.ok()) return poses.error();
  truth.poses = std::move(poses).value();
  if (!objects_wanted) return truth;
  const Result<fs::path> file = TruthFile(capture, annotation);
  if (!file.ok()) return file.error();
  Result<std::vector<TrueObject>> objects = ReadObjects(*file);
  if (!objects.ok()) return objects.error();
  truth.objects = std::move(objects).value();
  if (annotation.empty()) {
    if (Status status = CountVisible(capture, truth); !status.ok()) return status.error();
  }
  return truth;
}

Result<MapResult> ReadMapResult(const fs::path& workspace, const Truth& truth) {
  if (Status status = pipeline::CheckConsistency(workspace); !status.ok()) return status.error();
  MapResult result;
  result.workspace = workspace;
  const Result<std::vector<TimedPose>> poses = ReadTum(workspace / "optimize" / "trajectory.tum");
  if (!poses.ok()) return poses.error();
  Result<TrajectoryError> error =
      ComputeTrajectoryError(*poses, truth.poses, TrajectoryErrorOptions());
  if (!error.ok())
    return InvalidInput(fmt::format("{} and {}: cannot be aligned: {}",
                                    workspace.string(),
                                    (truth.capture / "groundtruth.txt").string(),
                                    error.error().message));
  result.trajectory = std::move(error).value();
  WarnOfForeignTruth(workspace, *poses, truth.capture, result.trajectory.ate_m.rmse);
  const fs::path file = workspace / "optimize" / "objects.json";
  const Result<std::string> text = storage::ReadFile(file);
  if (!text.ok()) return text.error();
  const Result<ObjectMap> map = artifact::DecodeObjectMap(*text, file.string());
  if (!map.ok()) return map.error();
  for (const MapObject& object : map->objects) {
    Result<MappedObject> mapped =
        ReadMapped(workspace, object, result.trajectory.truth_from_estimate);
    if (!mapped.ok()) return mapped.error();
    result.objects.push_back(std::move(mapped).value());
  }
  return result;
}

Result<std::vector<EvalPair>> PairsOf(const std::vector<std::string>& paths) {
  if (paths.empty() || paths.size() % 2 != 0)
    return InvalidConfig("expected WORKSPACE TRUTH, or several such pairs");
  std::vector<EvalPair> pairs;
  for (std::size_t i = 0; i < paths.size(); i += 2) pairs.push_back({paths[i], paths[i + 1]});
  return pairs;
}

std::vector<eval::PlacedBox> BoxesOf(const Truth& truth) {
  std::vector<eval::PlacedBox> boxes;
  for (const TrueObject& object : truth.objects) boxes.push_back(object.box);
  return boxes;
}

std::vector<eval::PlacedBox> BoxesOf(const MapResult& map) {
  std::vector<eval::PlacedBox> boxes;
  for (const MappedObject& object : map.objects) boxes.push_back(object.box);
  return boxes;
}

artifact::JsonValue ToJson(const eval::Interval& interval) {
  JsonObject row;
  row.emplace("mean", interval.mean);
  row.emplace("low", interval.low);
  row.emplace("high", interval.high);
  return artifact::JsonValue(std::move(row));
}

artifact::JsonValue ToJson(const eval::SurfaceComparison& surface) {
  JsonObject row;
  row.emplace("num_estimated", surface.num_estimated);
  row.emplace("num_true", surface.num_true);
  row.emplace("accuracy", surface.accuracy);
  row.emplace("completeness", surface.completeness);
  row.emplace("f_score", surface.f_score);
  row.emplace("accuracy_m", surface.accuracy_m);
  row.emplace("completeness_m", surface.completeness_m);
  return artifact::JsonValue(std::move(row));
}

}  // namespace deepslam::tools
