// The compact map: class, pose, size, score and shape code of every object, the room around them
// and the ground; enough to make the scene again without the workspace.
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "deepslam/core/ids.h"
#include "deepslam/core/image.h"
#include "deepslam/geometry/plane.h"
#include "deepslam/geometry/pose.h"
#include "deepslam/scene/layout.h"
#include "deepslam/scene/run_verdict.h"
#include "deepslam/scene/shape_candidate.h"

namespace deepslam {

// Digits of a checksum that a map keeps: 64 bits tell models apart, and the map stays small.
inline constexpr std::size_t kMapChecksumDigits = 16;

// How a shape is stored: by latents of a decoder, by a model of a library and its stretch
// (shape::StretchGrid), or by its own voxels.
struct CompactShape {
  std::vector<float> latents;
  std::string library_id;
  // First digits of the sha256 of the library model's voxels, and of the stretched model as binvox.
  std::string library_checksum;
  Eigen::Vector3d stretch = Eigen::Vector3d::Ones();  // ones = the library's model as it is
  std::string voxels_checksum;                        // empty = unknown
  std::string voxel_code;  // bytes of shape::EncodeVoxels; base64 in the file
};

struct CompactObject {
  ObjectId id;
  std::string name;  // "chair_03", as in the scene
  std::string class_name;
  double confidence = 0;  // [0, 1]
  CandidateSource source = CandidateSource::kRetrieval;
  Pose3 world_from_object;
  double scale_m = 1;
  Eigen::Vector3d size_m = Eigen::Vector3d::Zero();  // extent along the object's axes
  std::string credit;
  std::string note;
  CompactShape shape;
  std::optional<int> room = {};  // whose polygon holds it
  std::string stands_on = {};    // kOnFloor, kOnWall or another object's name; empty: not known
  std::optional<int> against_wall = {};  // that a side of it stands at
};
inline constexpr std::string_view kOnFloor = "floor";
inline constexpr std::string_view kOnWall = "wall";

// The room itself, in the map's world (z up). Ids are positions in their lists.
struct CompactRoom {
  // Corners counter-clockwise. An edge on which no wall of the room lies was not seen.
  std::vector<Eigen::Vector2d> polygon_m;
  double floor_m = 0;
  std::optional<double> ceiling_m;  // nothing: not seen
};
struct CompactWall {
  std::vector<int> rooms;
  Eigen::Vector2d from_m = Eigen::Vector2d::Zero();  // the room to the left of from -> to
  Eigen::Vector2d to_m = Eigen::Vector2d::Zero();
  double bottom_m = 0;
  double top_m = 0;
  double seen_share = 0;  // [0, 1], of its length
  double confidence = 0;  // [0, 1]
};
struct CompactOpening {
  int wall = 0;
  OpeningKind kind = OpeningKind::kDoor;
  Eigen::Vector2d from_m = Eigen::Vector2d::Zero();  // on the wall, in its direction
  Eigen::Vector2d to_m = Eigen::Vector2d::Zero();
  double bottom_m = 0;
  double top_m = 0;
  double confidence = 0;  // [0, 1]; below 0.5 is doubtful
};
struct CompactLayout {
  std::vector<CompactRoom> rooms;
  std::vector<CompactWall> walls;
  std::vector<CompactOpening> openings;
};

struct CompactMap {
  std::string tool_version;
  std::string capture_name;
  std::string capture_hash;
  std::optional<Plane> ground_world;
  // The seen piece of floor in the ground's plane: x, y in metres, counter-clockwise, no holes.
  std::vector<Eigen::Vector2d> ground_outline_m;
  std::map<std::string, Rgb8> class_colours;  // sRGB, of the classes in the map
  // Options of mesh.* that differ from the defaults: shapes are made by them.
  std::map<std::string, std::string> mesh_options;
  Verdict verdict = Verdict::kGood;
  std::vector<std::string> reasons;     // of the verdict
  std::optional<CompactLayout> layout;  // nothing in maps before version 5
  std::vector<CompactObject> objects;   // ascending id
};

}  // namespace deepslam
