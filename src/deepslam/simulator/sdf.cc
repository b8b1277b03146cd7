#include "deepslam/simulator/sdf.h"

#include <string_view>

#include <fmt/format.h>

#include "deepslam/simulator/xml_text.h"

namespace deepslam::simulator {
namespace {

// Of wood on wood.
constexpr std::string_view kFriction =
    "<surface><friction><ode><mu>0.7</mu><mu2>0.7</mu2></ode></friction></surface>";

std::string PoseElement(const Pose3& pose) {
  return fmt::format(
      "<pose>{} {}</pose>", Numbers(pose.translation_m), Numbers(RollPitchYaw(pose.rotation)));
}

std::string MeshElement(const std::string& file) {
  return fmt::format("<geometry><mesh><uri>meshes/{}</uri></mesh></geometry>", file);
}

void AddInertial(const RigidBody& body, std::string& text) {
  text += fmt::format(
      "        <inertial>\n          {}\n          <mass>{:.6g}</mass>\n"
      "          <inertia><ixx>{:.6g}</ixx><iyy>{:.6g}</iyy><izz>{:.6g}</izz><ixy>0</ixy>"
      "<ixz>0</ixz><iyz>0</iyz></inertia>\n        </inertial>\n",
      PoseElement({body.thing_from_axes, body.centre_of_mass}),
      body.mass_kg,
      body.inertia_kg_m2.x(),
      body.inertia_kg_m2.y(),
      body.inertia_kg_m2.z());
}

void AddVisual(const NamedThing& named, std::string& text) {
  const SimulatedThing& thing = *named.thing;
  const std::string colour = fmt::format("{:.3f} {:.3f} {:.3f} {:.3f}",
                                         thing.colour.r / 255.0,
                                         thing.colour.g / 255.0,
                                         thing.colour.b / 255.0,
                                         thing.opacity);
  text += fmt::format(
      "        <visual name=\"visual\">\n          {0}\n"
      "          <material><ambient>{1}</ambient><diffuse>{1}</diffuse></material>\n"
      "          <transparency>{2:.3f}</transparency>\n        </visual>\n",
      MeshElement(named.MeshFile()),
      colour,
      1 - thing.opacity);
}

void AddModel(const NamedThing& named, std::string& text) {
  const SimulatedThing& thing = *named.thing;
  const RigidBody& body = thing.body;
  text += fmt::format(
      "    <model name=\"{}\">\n      {}\n      <static>{}</static>\n      <link name=\"link\">\n",
      named.identifier,
      PoseElement(thing.world_from_thing),
      body.free ? "false" : "true");
  if (body.free) AddInertial(body, text);
  if (!thing.mesh.empty()) AddVisual(named, text);
  for (std::size_t n = 0; n < body.pieces.size(); ++n) {
    text += fmt::format("        <collision name=\"piece_{}\">{}{}</collision>\n",
                        n,
                        MeshElement(named.PieceName(n) + ".obj"),
                        kFriction);
  }
  text += "      </link>\n    </model>\n";
}

void AddFloor(std::string& text) {
  text += fmt::format(
      "    <model name=\"endless_floor\">\n      <static>true</static>\n      <link "
      "name=\"link\">\n"
      "        <collision name=\"plane\"><geometry><plane><normal>0 0 1</normal></plane></geometry>"
      "{}</collision>\n      </link>\n    </model>\n",
      kFriction);
}

}  // namespace

std::string SdfText(std::span<const NamedThing> things, const SimulatorScene& scene) {
  std::string text = fmt::format(
      "<?xml version=\"1.0\"?>\n<!-- {} -->\n<sdf version=\"1.7\">\n  <world name=\"scene\">\n"
      "    <light name=\"sun\" type=\"directional\"><direction>-0.3 -0.2 -1</direction></light>\n",
      XmlText(scene.provenance));
  if (scene.has_floor) AddFloor(text);
  for (const NamedThing& named : things) AddModel(named, text);
  return text + "  </world>\n</sdf>\n";
}

}  // namespace deepslam::simulator
