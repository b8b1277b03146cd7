#include "deepslam/simulator/simulator_files.h"

#include <cmath>
#include <cstdint>
#include <vector>

#include <fmt/format.h>

#include "deepslam/core/identifiers.h"
#include "deepslam/simulator/mjcf.h"
#include "deepslam/simulator/named_thing.h"
#include "deepslam/simulator/obj_text.h"
#include "deepslam/simulator/sdf.h"
#include "deepslam/simulator/urdf.h"

namespace deepslam::simulator {
namespace {

bool IsSound(const TriangleMesh& mesh) {
  for (const Eigen::Vector3f& p : mesh.vertices) {
    if (!p.allFinite()) return false;
  }
  for (const auto& face : mesh.faces) {
    for (const std::uint32_t corner : face) {
      if (corner >= mesh.vertices.size()) return false;
    }
  }
  return true;
}

Status Check(const SimulatedThing& thing) {
  bool sound = IsSound(thing.mesh);
  for (const TriangleMesh& piece : thing.body.pieces) sound = sound && IsSound(piece);
  if (!sound) return InvalidInput(thing.name + ": a vertex is not finite, or a face has none");
  const RigidBody& body = thing.body;
  const bool finite = thing.world_from_thing.translation_m.allFinite() &&
                      thing.world_from_thing.rotation.coeffs().allFinite() &&
                      std::isfinite(body.mass_kg) && body.centre_of_mass.allFinite() &&
                      body.inertia_kg_m2.allFinite() && body.thing_from_axes.coeffs().allFinite();
  if (!finite) return InvalidInput(thing.name + ": its pose or its mass is not finite");
  return Ok();
}

// Positions and rotations (x, y, z, w) by the name of the file in `objects`.
std::string PlacementsText(const std::vector<NamedThing>& things) {
  std::string rows;
  for (const NamedThing& named : things) {
    if (!named.thing->body.free) continue;
    const Eigen::Vector3d& t = named.thing->world_from_thing.translation_m;
    const Eigen::Quaterniond q = named.thing->world_from_thing.rotation.normalized();
    rows += fmt::format(
        "{} {{\"file\": \"objects/{}.urdf\", \"position_m\": [{}, {}, {}], "
        "\"rotation_xyzw\": [{}, {}, {}, {}]}}",
        rows.empty() ? "\n" : ",\n",
        named.identifier,
        t.x(),
        t.y(),
        t.z(),
        q.x(),
        q.y(),
        q.z(),
        q.w());
  }
  return fmt::format(
      "{{\"format\": \"deepslam/placements\", \"version\": 1, \"objects\": [{}{}]}}\n",
      rows,
      rows.empty() ? "" : "\n");
}

Status WriteMeshes(const NamedThing& named, const WriteFile& write) {
  const SimulatedThing& thing = *named.thing;
  Status status = Ok();
  if (!thing.mesh.empty()) status = write("meshes/" + named.MeshFile(), ObjText(thing.mesh));
  for (std::size_t n = 0; n < thing.body.pieces.size() && status.ok(); ++n) {
    status = write(fmt::format("meshes/{}.obj", named.PieceName(n)), ObjText(thing.body.pieces[n]));
  }
  if (status.ok() && thing.body.free) {
    status =
        write(fmt::format("objects/{}.urdf", named.identifier), ThingUrdfText(named, "../meshes"));
  }
  return status;
}

}  // namespace

Status WriteSimulatorFiles(const SimulatorScene& scene, const WriteFile& write) {
  Identifiers identifiers;
  // Names of elements of the files themselves.
  for (const char* taken : {"world", "endless_floor"}) static_cast<void>(identifiers.Take(taken));
  std::vector<NamedThing> things;
  for (const SimulatedThing& thing : scene.things) {
    if (Status status = Check(thing); !status.ok()) return status;
    things.push_back({&thing, identifiers.Take(thing.name)});
  }
  for (const NamedThing& named : things) {
    if (Status status = WriteMeshes(named, write); !status.ok()) return status;
  }
  Status status = write("scene.xml", MjcfText(things, scene));
  if (status.ok()) status = write("scene.urdf", UrdfText(things, scene));
  if (status.ok()) status = write("scene_fixed.urdf", FixedUrdfText(things, scene));
  if (status.ok()) status = write("scene.sdf", SdfText(things, scene));
  if (status.ok()) status = write("placements.json", PlacementsText(things));
  return status;
}

}  // namespace deepslam::simulator
