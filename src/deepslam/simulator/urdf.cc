#include "deepslam/simulator/urdf.h"

#include <fmt/format.h>

#include "deepslam/simulator/xml_text.h"

namespace deepslam::simulator {
namespace {

constexpr double kFloorSide_m = 200;  // as far as a map reaches
constexpr double kFloorDepth_m = 1;   // thick, so that nothing falls through in one step

std::string Origin(const Pose3& pose) {
  return fmt::format("<origin xyz=\"{}\" rpy=\"{}\"/>",
                     Numbers(pose.translation_m),
                     Numbers(RollPitchYaw(pose.rotation)));
}

void AddLink(const NamedThing& named, std::string_view meshes, std::string& text) {
  const SimulatedThing& thing = *named.thing;
  const RigidBody& body = thing.body;
  text += fmt::format("  <link name=\"{}\">\n", named.identifier);
  text += fmt::format(
      "    <inertial>\n      {}\n      <mass value=\"{:.6g}\"/>\n"
      "      <inertia ixx=\"{:.6g}\" iyy=\"{:.6g}\" izz=\"{:.6g}\" ixy=\"0\" ixz=\"0\" "
      "iyz=\"0\"/>\n"
      "    </inertial>\n",
      Origin({body.thing_from_axes, body.centre_of_mass}),
      body.mass_kg,
      body.inertia_kg_m2.x(),
      body.inertia_kg_m2.y(),
      body.inertia_kg_m2.z());
  if (!thing.mesh.empty()) {
    text += fmt::format(
        "    <visual>\n      <geometry><mesh filename=\"{}/{}\"/></geometry>\n"
        "      <material name=\"{}\"><color rgba=\"{:.3f} {:.3f} {:.3f} {:.3f}\"/></material>\n"
        "    </visual>\n",
        meshes,
        named.MeshFile(),
        named.identifier,
        thing.colour.r / 255.0,
        thing.colour.g / 255.0,
        thing.colour.b / 255.0,
        thing.opacity);
  }
  for (std::size_t n = 0; n < body.pieces.size(); ++n) {
    text += fmt::format(
        "    <collision><geometry><mesh filename=\"{}/{}.obj\"/></geometry></collision>\n",
        meshes,
        named.PieceName(n));
  }
  // Bullet's own element; others pass over it. The friction is that of wood on wood.
  text += "    <contact><lateral_friction value=\"0.7\"/></contact>\n  </link>\n";
}

void AddJoint(const NamedThing& named, std::string& text) {
  text += fmt::format(
      "  <joint name=\"{0}_joint\" type=\"{1}\">\n    {2}\n    <parent link=\"world\"/>\n"
      "    <child link=\"{0}\"/>\n  </joint>\n",
      named.identifier,
      named.thing->body.free ? "floating" : "fixed",
      Origin(named.thing->world_from_thing));
}

// Links without a mass are none to sdformat, and a scene without walls has no other that is fixed.
void AddFloor(std::string& text) {
  text += fmt::format(
      "  <link name=\"endless_floor\">\n    <inertial>\n      <mass value=\"1\"/>\n"
      "      <inertia ixx=\"1\" ixy=\"0\" ixz=\"0\" iyy=\"1\" iyz=\"0\" izz=\"1\"/>\n"
      "    </inertial>\n    <collision>\n"
      "      <origin xyz=\"0 0 {0}\" rpy=\"0 0 0\"/>\n"
      "      <geometry><box size=\"{1} {1} {2}\"/></geometry>\n    </collision>\n"
      "    <contact><lateral_friction value=\"0.7\"/></contact>\n  </link>\n"
      "  <joint name=\"endless_floor_joint\" type=\"fixed\">\n    <parent link=\"world\"/>\n"
      "    <child link=\"endless_floor\"/>\n  </joint>\n",
      -kFloorDepth_m / 2,
      kFloorSide_m,
      kFloorDepth_m);
}

std::string Text(std::span<const NamedThing> things, const SimulatorScene& scene, bool with_free) {
  std::string text = fmt::format(
      "<?xml version=\"1.0\"?>\n<!-- {} -->\n<robot name=\"scene\">\n"
      "  <link name=\"world\"/>\n",
      XmlText(scene.provenance));
  if (scene.has_floor) AddFloor(text);
  for (const NamedThing& named : things) {
    if (named.thing->body.free && !with_free) continue;
    AddLink(named, "meshes", text);
    AddJoint(named, text);
  }
  return text + "</robot>\n";
}

}  // namespace

std::string UrdfText(std::span<const NamedThing> things, const SimulatorScene& scene) {
  return Text(things, scene, true);
}

std::string FixedUrdfText(std::span<const NamedThing> things, const SimulatorScene& scene) {
  return Text(things, scene, false);
}

std::string ThingUrdfText(const NamedThing& named, std::string_view mesh_folder) {
  std::string text =
      fmt::format("<?xml version=\"1.0\"?>\n<robot name=\"{}\">\n", named.identifier);
  AddLink(named, mesh_folder, text);
  return text + "</robot>\n";
}

}  // namespace deepslam::simulator
