// Writes a workspace whose map is the truth of a rendered capture, so that the eval commands can be
// tried on a perfect result:
//   deepslam_truth_workspace CAPTURE WORKSPACE [TURNS]
// TURNS: every object's model is turned about its vertical by so many quarters and placed turned
// back, so that it fills the same space; 0 by default. `fuse/room.ply` holds the objects' own
// surfaces where they stand.
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <numbers>
#include <string>
#include <utility>

#include "deepslam/artifact/json_reader.h"
#include "deepslam/artifact/objects_json.h"
#include "deepslam/artifact/ply.h"
#include "deepslam/artifact/proposals_json.h"
#include "deepslam/artifact/registrations_json.h"
#include "deepslam/artifact/scene_json.h"
#include "deepslam/shape/binvox.h"
#include "deepslam/shape/stretch.h"
#include "deepslam/shape/voxelize.h"
#include "deepslam/storage/store.h"

namespace deepslam {
namespace {

namespace fs = std::filesystem;

template <typename T>
T Must(Result<T> result) {
  if (result.ok()) return std::move(result).value();
  std::fprintf(stderr, "%s\n", result.error().message.c_str());
  std::exit(1);
}

void Write(const fs::path& file, const std::string& bytes) {
  const Status folders = storage::MakeFolders(file.parent_path());
  const Status written = storage::WriteFileAtomically(file, bytes);
  if (folders.ok() && written.ok()) return;
  std::fprintf(stderr, "%s cannot be written\n", file.c_str());
  std::exit(1);
}

struct TrueObject {
  std::string class_name;
  TriangleMesh mesh;  // object frame, as the map has it
  VoxelGrid grid;
  double scale_m = 1;
  Pose3 world_from_object;
};

void Turn(int turns, TrueObject& object) {
  const Eigen::Quaterniond turn(
      Eigen::AngleAxisd(turns * std::numbers::pi / 2, Eigen::Vector3d::UnitZ()));
  for (Eigen::Vector3f& v : object.mesh.vertices) v = (turn * v.cast<double>()).cast<float>();
  object.grid = shape::TurnGrid(object.grid, turns);
  object.world_from_object.rotation = object.world_from_object.rotation * turn.conjugate();
}

std::vector<TrueObject> ReadTruth(const fs::path& capture, int turns) {
  const fs::path file = capture / "truth" / "objects.json";
  const std::string text = Must(storage::ReadFile(file));
  artifact::JsonReader reader(text, file.string(), "", 0);
  std::vector<TrueObject> objects;
  for (const artifact::JsonNode& node : reader.root()["objects"].Items()) {
    TrueObject object;
    object.class_name = node["class"].String();
    object.scale_m = node["scale_m"].Number();
    object.world_from_object = artifact::FromJson<Pose3>(node);
    const fs::path mesh = capture / "truth" / node["mesh"].String();
    object.mesh = Must(artifact::DecodePly(Must(storage::ReadFile(mesh)), mesh.string())).mesh;
    object.grid = Must(shape::Voxelize(object.mesh));
    Turn(turns, object);
    objects.push_back(std::move(object));
  }
  return objects;
}

ViewRegistration OneView() {
  ViewRegistration view;
  view.view = DetectionId{0};
  view.frame = FrameIdx{0};
  view.ok = true;
  return view;
}

void WriteWorkspace(const fs::path& capture, const fs::path& workspace, int turns) {
  const std::string poses = Must(storage::ReadFile(capture / "groundtruth.txt"));
  Write(workspace / "track" / "trajectory.tum", poses);
  Write(workspace / "optimize" / "trajectory.tum", poses);
  ObjectMap map;
  Proposals proposals;
  std::vector<CandidateRegistration> registrations;
  TriangleMesh room;
  int id = 0;
  for (const TrueObject& object : ReadTruth(capture, turns)) {
    const std::string model = "true_" + std::to_string(id);
    MapObject mapped;
    mapped.id = ObjectId{id};
    mapped.class_name = object.class_name;
    mapped.chosen = CandidateId{id};
    mapped.model = model;
    mapped.scale_m = object.scale_m;
    mapped.world_from_object = object.world_from_object;
    mapped.confidence = 1;
    mapped.views = {OneView()};
    mapped.scores.emplace_back();
    mapped.scores[0].candidate = CandidateId{id};
    mapped.scores[0].score = 1;
    map.objects.push_back(mapped);
    ShapeCandidate candidate;
    candidate.id = CandidateId{id};
    candidate.object = ObjectId{id};
    candidate.model = model;
    candidate.library_id = model;
    proposals.candidates.push_back(candidate);
    proposals.models.emplace(model, object.grid);
    CandidateRegistration registration;
    registration.candidate = CandidateId{id};
    registration.ok = true;
    registration.scale_m = object.scale_m;
    registration.world_from_object = object.world_from_object;
    registration.views = {OneView()};
    registrations.push_back(registration);
    char name[64];
    std::snprintf(name, sizeof name, "%s_%02d.ply", object.class_name.c_str(), id);
    Write(workspace / "mesh" / "objects" / name,
          Must(artifact::EncodePly({object.mesh, {}, {}}, name)));
    for (const char* stage : {"loops", "propose"})
      Write(workspace / stage / "models" / (model + ".binvox"), shape::WriteBinvox(object.grid));
    const auto first = static_cast<std::uint32_t>(room.vertices.size());
    for (const Eigen::Vector3f& v : object.mesh.vertices)
      room.vertices.push_back((object.world_from_object * v.cast<double>()).cast<float>());
    for (const auto& f : object.mesh.faces)
      room.faces.push_back({f[0] + first, f[1] + first, f[2] + first});
    ++id;
  }
  Write(workspace / "optimize" / "objects.json", Must(artifact::EncodeObjectMap(map, "map")));
  Write(workspace / "propose" / "candidates.json",
        Must(artifact::EncodeProposals(proposals, "candidates")));
  Write(workspace / "register" / "registrations.json",
        Must(artifact::EncodeRegistrations(registrations, "registrations")));
  Write(workspace / "fuse" / "room.ply", Must(artifact::EncodePly({room, {}, {}}, "room")));
  Write(workspace / "export" / "map.json", "{}\n");
}

}  // namespace
}  // namespace deepslam

int main(int argc, char** argv) {
  if (argc != 3 && argc != 4) return 2;
  deepslam::WriteWorkspace(argv[1], argv[2], argc == 4 ? std::atoi(argv[3]) : 0);
  return 0;
}
