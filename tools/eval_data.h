// What the `eval` commands read: the truth about a capture, and a workspace's result brought into
// the true world.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "deepslam/artifact/json_value.h"
#include "deepslam/core/result.h"
#include "deepslam/eval/bootstrap.h"
#include "deepslam/eval/placement.h"
#include "deepslam/eval/surface_comparison.h"
#include "deepslam/geometry/trajectory_error.h"
#include "deepslam/scene/object_map.h"
#include "deepslam/scene/triangle_mesh.h"
#include "deepslam/scene/voxel_grid.h"

namespace deepslam::tools {

// Of the points that Chamfer distances draw: the same for all shapes, so that equal ones have 0.
inline constexpr std::uint64_t kChamferSeed = 1;

// An object that covers less of every frame cannot be asked for.
inline constexpr double kVisibleShare = 0.005;

struct TrueObject {
  int number = 0;       // in the truth's list and in the instance masks, from 1
  eval::PlacedBox box;  // true world
  TriangleMesh mesh;    // object frame, metres; the box itself where only that is known
  bool has_shape = false;
  VoxelGrid grid;
  shape::Symmetry symmetry = shape::Symmetry::kNone;
  int visible_px = -1;  // most pixels in one frame; -1 where no masks tell
};

struct Truth {
  std::filesystem::path capture;
  std::vector<TrueObject> objects;  // those that some frame sees
  std::vector<TimedPose> poses;
  int num_unseen = 0;  // objects that no frame sees well enough to ask for them
};

// Of a workspace: what this program wrote, and nothing else.
[[nodiscard]] Result<std::vector<TimedPose>> ReadTum(const std::filesystem::path& file);
// Of a capture, or given as truth: whatever `run` takes as a capture's groundtruth.txt is read as
// it is there. What is left out or sorted is told on stderr.
[[nodiscard]] Result<std::vector<TimedPose>> ReadCaptureTum(const std::filesystem::path& file);

// `capture` is a folder with groundtruth.txt and truth/objects.json (`deepslam synth`) or
// objects.json (annotated by hand, docs/evaluation.md); `annotation` names another file in its
// place. `objects_wanted` false: only the poses.
[[nodiscard]] Result<Truth> ReadTruth(const std::filesystem::path& capture,
                                      const std::string& annotation,
                                      bool objects_wanted = true);

struct MappedObject {
  MapObject object;
  std::string name;
  eval::PlacedBox box;  // true world
  Pose3 true_world_from_object;
  TriangleMesh mesh;  // object frame, metres
  VoxelGrid grid;     // of the chosen model
};

struct MapResult {
  std::filesystem::path workspace;
  std::vector<MappedObject> objects;
  TrajectoryError trajectory;  // truth_from_estimate brings the map into the true world
};
// The final map, aligned by the trajectory's rigid motion.
[[nodiscard]] Result<MapResult> ReadMapResult(const std::filesystem::path& workspace,
                                              const Truth& truth);

[[nodiscard]] Result<VoxelGrid> ReadGrid(const std::filesystem::path& file);
[[nodiscard]] Result<TriangleMesh> ReadPlyMesh(const std::filesystem::path& file);

// Pairs "WORKSPACE TRUTH WORKSPACE TRUTH ..." of the command line.
struct EvalPair {
  std::filesystem::path workspace;
  std::filesystem::path truth;
};
[[nodiscard]] Result<std::vector<EvalPair>> PairsOf(const std::vector<std::string>& paths);

[[nodiscard]] std::vector<eval::PlacedBox> BoxesOf(const Truth& truth);
[[nodiscard]] std::vector<eval::PlacedBox> BoxesOf(const MapResult& map);

[[nodiscard]] artifact::JsonValue ToJson(const eval::Interval& interval);
[[nodiscard]] artifact::JsonValue ToJson(const eval::SurfaceComparison& surface);

}  // namespace deepslam::tools
