// A map for programs that ask what is where: objects, the rooms and walls around them, and how they
// stand to each other. World of the map: m, z up.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "deepslam/core/ids.h"
#include "deepslam/geometry/box.h"
#include "deepslam/geometry/pose.h"
#include "deepslam/scene/compact_map.h"
#include "deepslam/scene/object_class.h"
#include "deepslam/scene/run_verdict.h"
#include "deepslam/scene/shape_candidate.h"
#include "deepslam/scene/triangle_mesh.h"

namespace deepslam::presentation {

struct GraphObject {
  ObjectId id;
  std::string name;  // "chair_03", as in the scene
  std::string class_name;
  CommonLabels labels;
  double confidence = 0;  // [0, 1]
  CandidateSource source = CandidateSource::kRetrieval;
  Pose3 world_from_object;  // metric object frame
  // The smallest boxes that hold its mesh: along its own axes, and along the world's. Points at its
  // origin where it has none.
  Eigen::Vector3d centre_world = Eigen::Vector3d::Zero();
  Eigen::Vector3d size_m = Eigen::Vector3d::Zero();
  Box3 box_world;
  bool has_front = true;  // false: things of its class are alike from several sides
  bool has_mesh = true;
  double volume_m3 = 0;  // of its closed mesh
  std::optional<int> room;
  std::string credit;
  std::string note;
};

// In the alphabet's order of their names in the file.
enum class Predicate { kAgainstWall, kHangsOn, kInFrontOf, kInRoom, kNextTo, kStandsOn };

struct GraphRelation {
  std::string subject;  // name of an object
  Predicate predicate = Predicate::kInRoom;
  std::string object;                // name of an object, a room or a wall, or kOnFloor
  std::optional<double> distance_m;  // on the floor plan, of kNextTo and kInFrontOf
};

struct SceneGraph {
  std::string tool_version;
  std::string capture_name;
  std::string capture_hash;
  RunVerdict verdict;
  CompactLayout layout;
  std::vector<GraphObject> objects;  // ascending id
  // By the place of their subjects in `objects`, then by predicate, then by the name of their
  // object.
  std::vector<GraphRelation> relations;
};

// `meshes` and `volumes_m3` have one entry per object of the map, in its order; meshes in the
// metric object frame, empty: without a surface. Poses, sizes and the layout are those of the map;
// other places are rounded as its are.
[[nodiscard]] SceneGraph MakeSceneGraph(const CompactMap& map,
                                        std::span<const TriangleMesh> meshes,
                                        std::span<const double> volumes_m3,
                                        const ClassTable& classes);

}  // namespace deepslam::presentation
