#include "deepslam/simulator/mjcf.h"

#include <fmt/format.h>

#include "deepslam/simulator/xml_text.h"

namespace deepslam::simulator {
namespace {

std::string Rgba(const SimulatedThing& thing) {
  return fmt::format("{:.3f} {:.3f} {:.3f} {:.3f}",
                     thing.colour.r / 255.0,
                     thing.colour.g / 255.0,
                     thing.colour.b / 255.0,
                     thing.opacity);
}

void AddAssets(const NamedThing& named, std::string& text) {
  // Of a mesh that is only seen no volume is asked: it may be open.
  if (!named.thing->mesh.empty()) {
    text += fmt::format("    <mesh name=\"{}\" file=\"{}\" inertia=\"shell\"/>\n",
                        named.identifier,
                        named.MeshFile());
  }
  for (std::size_t n = 0; n < named.thing->body.pieces.size(); ++n) {
    text += fmt::format("    <mesh name=\"{0}\" file=\"{0}.obj\" inertia=\"convex\"/>\n",
                        named.PieceName(n));
  }
}

void AddBody(const NamedThing& named, std::string& text) {
  const SimulatedThing& thing = *named.thing;
  const RigidBody& body = thing.body;
  text += fmt::format("    <body name=\"{}\" pos=\"{}\" quat=\"{}\">\n",
                      named.identifier,
                      Numbers(thing.world_from_thing.translation_m),
                      WxyzOf(thing.world_from_thing.rotation));
  if (body.free) {
    text += fmt::format(
        "      <freejoint name=\"{}_joint\"/>\n"
        "      <inertial mass=\"{:.6g}\" pos=\"{}\" quat=\"{}\" "
        "diaginertia=\"{:.6g} {:.6g} {:.6g}\"/>\n",
        named.identifier,
        body.mass_kg,
        Numbers(body.centre_of_mass),
        WxyzOf(body.thing_from_axes),
        body.inertia_kg_m2.x(),
        body.inertia_kg_m2.y(),
        body.inertia_kg_m2.z());
  }
  if (!thing.mesh.empty()) {
    text += fmt::format(
        "      <geom class=\"visual\" mesh=\"{}\" rgba=\"{}\"/>\n", named.identifier, Rgba(thing));
  }
  for (std::size_t n = 0; n < body.pieces.size(); ++n)
    text += fmt::format("      <geom class=\"collision\" mesh=\"{}\"/>\n", named.PieceName(n));
  text += "    </body>\n";
}

}  // namespace

std::string MjcfText(std::span<const NamedThing> things, const SimulatorScene& scene) {
  // An elliptic cone and a high ratio keep what stands on a floor from creeping; the friction is
  // that of wood on wood. Bodies are drawn apart by no margin.
  std::string text = fmt::format(
      "<!-- {} -->\n"
      "<mujoco model=\"scene\">\n"
      "  <compiler angle=\"radian\" meshdir=\"meshes\" autolimits=\"true\"/>\n"
      "  <option timestep=\"0.002\" integrator=\"implicitfast\" cone=\"elliptic\" "
      "impratio=\"10\"/>\n"
      "  <default>\n"
      "    <default class=\"visual\">\n"
      "      <geom type=\"mesh\" contype=\"0\" conaffinity=\"0\" group=\"2\"/>\n"
      "    </default>\n"
      "    <default class=\"collision\">\n"
      "      <geom type=\"mesh\" group=\"3\" friction=\"0.7 0.005 0.0001\"/>\n"
      "    </default>\n"
      "  </default>\n"
      "  <asset>\n",
      XmlText(scene.provenance));
  for (const NamedThing& named : things) AddAssets(named, text);
  text +=
      "  </asset>\n"
      "  <worldbody>\n"
      "    <light pos=\"0 0 4\" dir=\"0 0 -1\" directional=\"true\"/>\n";
  if (scene.has_floor) {
    text +=
        "    <geom name=\"endless_floor\" type=\"plane\" size=\"0 0 1\" "
        "friction=\"0.7 0.005 0.0001\" rgba=\"0.7 0.68 0.65 1\"/>\n";
  }
  for (const NamedThing& named : things) AddBody(named, text);
  return text + "  </worldbody>\n</mujoco>\n";
}

}  // namespace deepslam::simulator
