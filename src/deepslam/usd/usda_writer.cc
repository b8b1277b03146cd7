#include "deepslam/usd/usda_writer.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string_view>

#include <fmt/format.h>

#include "deepslam/core/identifiers.h"
#include "deepslam/geometry/box.h"
#include "deepslam/usd/usda_text.h"

namespace deepslam::usd {
namespace {

constexpr double kGravity_m_s2 = 9.81;  // on Earth, to its usual digits

Status CheckMesh(const TriangleMesh& mesh, const std::string& name) {
  for (const auto& face : mesh.faces) {
    for (const std::uint32_t corner : face) {
      if (corner >= mesh.vertices.size())
        return InvalidInput(
            fmt::format("{}: a face has vertex {} of {}", name, corner, mesh.vertices.size()));
    }
  }
  for (const Eigen::Vector3f& vertex : mesh.vertices) {
    if (!vertex.allFinite()) return InvalidInput(name + ": a vertex is not finite");
  }
  if (!mesh.colours.empty() && mesh.colours.size() != mesh.vertices.size())
    return InvalidInput(name + ": has not one colour per vertex");
  return Ok();
}

Status CheckPrim(const UsdPrim& prim) {
  const Pose3& pose = prim.world_from_prim;
  if (!pose.translation_m.allFinite() || !pose.rotation.coeffs().allFinite())
    return InvalidInput(prim.name + ": its pose is not finite");
  if (prim.body) {
    for (const TriangleMesh& piece : prim.body->pieces) {
      if (Status status = CheckMesh(piece, prim.name); !status.ok()) return status;
    }
  }
  return CheckMesh(prim.mesh, prim.name);
}

Eigen::Vector3d MeanColour(const UsdPrim& prim) {
  if (prim.mesh.colours.empty()) return LinearOf(prim.colour);
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Rgb8& colour : prim.mesh.colours) sum += LinearOf(colour);
  return sum / static_cast<double>(prim.mesh.colours.size());
}

// Writes lines, indented as deep as the braces are.
class UsdaWriter {
 public:
  explicit UsdaWriter(std::string& text) : text_(text) {}

  void Line(std::string_view line) {
    text_.append(4 * depth_, ' ');
    text_ += line;
    text_ += '\n';
  }
  // `def TYPE "NAME" (METADATA)`; Close ends it.
  void Open(std::string_view head, const std::vector<std::string>& metadata = {}) {
    Line(fmt::format("{}{}", head, metadata.empty() ? "" : " ("));
    ++depth_;
    for (const std::string& line : metadata) Line(line);
    --depth_;
    if (!metadata.empty()) Line(")");
    Line("{");
    ++depth_;
  }
  void Close() {
    --depth_;
    Line("}");
  }
  // `DECLARATION = VALUE`, the value appended by `append`; with a line of metadata behind it.
  template <typename Append>
  void Attribute(std::string_view declaration, const Append& append, std::string_view more = {}) {
    text_.append(4 * depth_, ' ');
    text_ += declaration;
    text_ += " = ";
    append(text_);
    if (!more.empty()) text_ += fmt::format(" ({})", more);
    text_ += '\n';
  }
  void Vector(std::string_view declaration, const Eigen::Vector3d& value) {
    Attribute(declaration, [&](std::string& text) { AppendVector(value, text); });
  }
  void Number(std::string_view declaration, double value) {
    Attribute(declaration, [&](std::string& text) { AppendNumber(value, text); });
  }
  void Pose(const Pose3& pose) {
    Vector("double3 xformOp:translate", pose.translation_m);
    const Eigen::Quaterniond q = pose.rotation.normalized();
    Line(fmt::format("quatd xformOp:orient = ({}, {}, {}, {})", q.w(), q.x(), q.y(), q.z()));
    Line("uniform token[] xformOpOrder = [\"xformOp:translate\", \"xformOp:orient\"]");
  }

 private:
  std::string& text_;
  std::size_t depth_ = 0;
};

// Custom data of a prim or of the layer, as lines of metadata.
void AddDictionary(std::string_view name, const UsdPrim& prim, std::vector<std::string>& lines) {
  lines.push_back(fmt::format("{} = {{", name));
  lines.emplace_back("    dictionary deepslam = {");
  for (const auto& [key, value] : prim.texts)
    lines.push_back(fmt::format("        string {} = {}", IdentifierOf(key), Quoted(value)));
  for (const auto& [key, value] : prim.numbers) {
    if (std::isfinite(value))
      lines.push_back(fmt::format("        double {} = {}", IdentifierOf(key), value));
  }
  lines.emplace_back("    }");
  lines.emplace_back("}");
}

// Its vertex colours through a primvar reader; readers without one show the mean.
void WriteMaterial(const UsdPrim& prim, const std::string& path, UsdaWriter& out) {
  const std::string material = path + "/material";
  out.Open("def Material \"material\"");
  out.Line(fmt::format("token outputs:surface.connect = <{}/surface.outputs:surface>", material));
  out.Open("def Shader \"surface\"");
  out.Line("uniform token info:id = \"UsdPreviewSurface\"");
  if (prim.mesh.colours.empty()) {
    out.Vector("color3f inputs:diffuseColor", MeanColour(prim));
  } else {
    out.Line(
        fmt::format("color3f inputs:diffuseColor.connect = <{}/colours.outputs:result>", material));
  }
  out.Number("float inputs:opacity", prim.opacity);
  out.Line("float inputs:roughness = 0.8");
  out.Line("float inputs:metallic = 0");
  out.Line("token outputs:surface");
  out.Close();
  if (!prim.mesh.colours.empty()) {
    out.Open("def Shader \"colours\"");
    out.Line("uniform token info:id = \"UsdPrimvarReader_float3\"");
    out.Line("string inputs:varname = \"displayColor\"");
    out.Vector("float3 inputs:fallback", MeanColour(prim));
    out.Line("float3 outputs:result");
    out.Close();
  }
  out.Close();
}

void WriteGeometry(const TriangleMesh& mesh, UsdaWriter& out) {
  Box3 box;
  for (const Eigen::Vector3f& vertex : mesh.vertices) box.Extend(vertex.cast<double>());
  out.Attribute("float3[] extent", [&](std::string& text) {
    text += '[';
    AppendVector(box.min, text);
    text += ", ";
    AppendVector(box.max, text);
    text += ']';
  });
  out.Attribute("int[] faceVertexCounts",
                [&](std::string& text) { AppendCounts(mesh.faces.size(), text); });
  out.Attribute("int[] faceVertexIndices", [&](std::string& text) { AppendCorners(mesh, text); });
  out.Attribute("point3f[] points", [&](std::string& text) { AppendPoints(mesh.vertices, text); });
  out.Line("uniform token subdivisionScheme = \"none\"");
}

// Called as its Xform is: programs that make one thing of the two, as Blender does, take its name.
void WriteMesh(const UsdPrim& prim, const std::string& path, UsdaWriter& out) {
  std::string schemas = "\"MaterialBindingAPI\"";
  const bool collides = prim.body && prim.body->pieces.empty();
  if (collides) schemas += ", \"PhysicsCollisionAPI\", \"PhysicsMeshCollisionAPI\"";
  out.Open(fmt::format("def Mesh \"{}\"", path.substr(path.rfind('/') + 1)),
           {fmt::format("prepend apiSchemas = [{}]", schemas)});
  WriteGeometry(prim.mesh, out);
  out.Line(fmt::format("uniform bool doubleSided = {}", prim.two_sided ? "1" : "0"));
  if (prim.mesh.colours.empty()) {
    const std::vector<Rgb8> colour = {prim.colour};
    out.Attribute("color3f[] primvars:displayColor",
                  [&](std::string& text) { AppendColours(colour, text); });
  } else {
    out.Attribute(
        "color3f[] primvars:displayColor",
        [&](std::string& text) { AppendColours(prim.mesh.colours, text); },
        "interpolation = \"vertex\"");
  }
  if (prim.opacity < 1)
    out.Line(fmt::format("float[] primvars:displayOpacity = [{}]", prim.opacity));
  out.Line(fmt::format("rel material:binding = <{}/material>", path));
  if (collides) out.Line("uniform token physics:approximation = \"none\"");
  out.Close();
}

// Pieces are convex already: their hulls are what they are.
void WritePieces(const std::vector<TriangleMesh>& pieces, UsdaWriter& out) {
  out.Open("def Xform \"collision\"");
  out.Line("uniform token purpose = \"guide\"");
  for (std::size_t n = 0; n < pieces.size(); ++n) {
    out.Open(fmt::format("def Mesh \"piece_{:02}\"", n),
             {"prepend apiSchemas = [\"PhysicsCollisionAPI\", \"PhysicsMeshCollisionAPI\"]"});
    WriteGeometry(pieces[n], out);
    out.Line("uniform token physics:approximation = \"convexHull\"");
    out.Close();
  }
  out.Close();
}

// The attributes that Blender makes custom properties of, called as those of the glTF scene.
void WriteUserProperties(const UsdPrim& prim, UsdaWriter& out) {
  out.Line(fmt::format("custom string userProperties:class = {}", Quoted(prim.label)));
  if (const auto found = prim.numbers.find("instance"); found != prim.numbers.end())
    out.Line(fmt::format("custom int userProperties:instance = {:.0f}", found->second));
  if (const auto found = prim.numbers.find("confidence"); found != prim.numbers.end())
    out.Number("custom double userProperties:score", found->second);
}

void WriteBody(const RigidBody& body, UsdaWriter& out) {
  if (!body.free) return;
  out.Number("float physics:mass", body.mass_kg);
  out.Vector("point3f physics:centerOfMass", body.centre_of_mass);
  out.Vector("float3 physics:diagonalInertia", body.inertia_kg_m2);
  const Eigen::Quaterniond& q = body.thing_from_axes;
  out.Line(
      fmt::format("quatf physics:principalAxes = ({}, {}, {}, {})", q.w(), q.x(), q.y(), q.z()));
}

void WritePrim(const UsdPrim& prim,
               const std::string& parent,
               Identifiers& names,
               UsdaWriter& out) {
  const std::string identifier = names.Take(prim.name);
  const std::string path = parent + "/" + identifier;
  std::string schemas = "\"SemanticsLabelsAPI:class\", \"SemanticsAPI:Semantics\"";
  if (prim.body && prim.body->free) schemas += ", \"PhysicsRigidBodyAPI\", \"PhysicsMassAPI\"";
  std::vector<std::string> metadata = {fmt::format("prepend apiSchemas = [{}]", schemas)};
  AddDictionary("customData", prim, metadata);
  metadata.push_back("displayName = " + Quoted(prim.name));
  metadata.emplace_back("kind = \"component\"");
  out.Open(fmt::format("def Xform \"{}\"", identifier), metadata);
  out.Line(fmt::format("token[] semantics:labels:class = [{}]", Quoted(prim.label)));
  out.Line(fmt::format("string semantic:Semantics:params:semanticData = {}", Quoted(prim.label)));
  out.Line("string semantic:Semantics:params:semanticType = \"class\"");
  WriteUserProperties(prim, out);
  out.Pose(prim.world_from_prim);
  if (prim.body) WriteBody(*prim.body, out);
  if (!prim.mesh.empty()) {
    WriteMaterial(prim, path, out);
    WriteMesh(prim, path, out);
  }
  if (prim.body && !prim.body->pieces.empty()) WritePieces(prim.body->pieces, out);
  out.Close();
}

bool HasBodies(const UsdScene& scene) {
  return std::any_of(scene.groups.begin(), scene.groups.end(), [](const UsdGroup& group) {
    return std::any_of(group.prims.begin(), group.prims.end(), [](const UsdPrim& prim) {
      return prim.body.has_value();
    });
  });
}

void WriteLayerMetadata(const UsdScene& scene, UsdaWriter& out) {
  UsdPrim layer;
  layer.texts = scene.provenance;
  std::vector<std::string> lines;
  AddDictionary("customLayerData", layer, lines);
  out.Line("#usda 1.0");
  out.Line("(");
  for (const std::string& line : lines) out.Line("    " + line);
  out.Line("    defaultPrim = \"World\"");
  out.Line("    kilogramsPerUnit = 1");
  out.Line("    metersPerUnit = 1");
  out.Line("    upAxis = \"Z\"");
  out.Line(")");
  out.Line("");
}

}  // namespace

Result<std::string> WriteUsda(const UsdScene& scene) {
  std::string text;
  UsdaWriter out(text);
  WriteLayerMetadata(scene, out);
  out.Open("def Xform \"World\"", {"kind = \"assembly\""});
  if (HasBodies(scene)) {
    out.Open("def PhysicsScene \"physics\"");
    out.Line("vector3f physics:gravityDirection = (0, 0, -1)");
    out.Number("float physics:gravityMagnitude", kGravity_m_s2);
    out.Close();
  }
  for (const UsdGroup& group : scene.groups) {
    out.Open(fmt::format("def Xform \"{}\"", group.name), {"kind = \"group\""});
    Identifiers names;
    for (const UsdPrim& prim : group.prims) {
      if (Status status = CheckPrim(prim); !status.ok()) return status.error();
      WritePrim(prim, "/World/" + group.name, names, out);
    }
    out.Close();
  }
  out.Close();
  return text;
}

}  // namespace deepslam::usd
