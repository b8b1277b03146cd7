// That OpenUSD opens the files, and finds in them what the map says, is shown in tests/exports.
#include "deepslam/usd/usda_writer.h"

#include <limits>
#include <string>

#include <gmock/gmock.h>

#include "support/box_meshes.h"

namespace deepslam::usd {
namespace {

using testing::HasSubstr;
using testing::Not;
using testing_support::Tetrahedron;

UsdScene OnePrim(const std::string& name) {
  UsdPrim prim;
  prim.name = name;
  prim.label = "chair";
  prim.mesh = Tetrahedron();
  prim.world_from_prim.translation_m = {1, 2, 0.5};
  prim.texts["class"] = "chair";
  prim.numbers["confidence"] = 0.5;
  return {{{"Objects", {prim}}}, {}};
}

std::size_t CountOf(const std::string& part, const std::string& text) {
  std::size_t count = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1))
    ++count;
  return count;
}

TEST(WriteUsda, SaysUnitsAxisAndWhatIsInIt) {
  const Result<std::string> text = WriteUsda(OnePrim("chair_03"));
  ASSERT_TRUE(text.ok()) << text.error().message;
  for (const char* part : {"#usda 1.0",
                           "metersPerUnit = 1",
                           "upAxis = \"Z\"",
                           "defaultPrim = \"World\"",
                           "def Xform \"chair_03\"",
                           "def Mesh \"chair_03\"",
                           "custom string userProperties:class = \"chair\"",
                           "custom double userProperties:score = 0.5",
                           "semantics:labels:class = [\"chair\"]",
                           "double3 xformOp:translate = (1, 2, 0.5)",
                           "float3[] extent = [(0, 0, 0), (1, 1, 1)]",
                           "point3f[] points = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]"})
    EXPECT_THAT(*text, HasSubstr(part));
  EXPECT_THAT(*text, Not(HasSubstr("physics")));
  EXPECT_THAT(*text, HasSubstr("doubleSided = 0"));
  EXPECT_EQ(CountOf("{", *text), CountOf("}", *text));
  EXPECT_EQ(*text, *WriteUsda(OnePrim("chair_03")));
}

TEST(WriteUsda, ColoursAreLinearAndShownByTheMaterial) {
  UsdScene scene = OnePrim("chair");
  scene.groups[0].prims[0].mesh.colours = {{0, 0, 0}, {255, 255, 255}, {188, 0, 0}, {0, 0, 0}};
  const std::string text = *WriteUsda(scene);
  EXPECT_THAT(text, HasSubstr("(0, 0, 0), (1, 1, 1), (0.50289, 0, 0), (0, 0, 0)"));
  EXPECT_THAT(text, HasSubstr("interpolation = \"vertex\""));
  EXPECT_THAT(text, HasSubstr("UsdPrimvarReader_float3"));
  EXPECT_THAT(*WriteUsda(OnePrim("chair")), Not(HasSubstr("UsdPrimvarReader_float3")));
}

TEST(WriteUsda, NamesBecomeIdentifiersThatAreTakenOnce) {
  UsdScene scene = OnePrim("Küche \"2\"\n");
  for (const char* name : {"Küche \"2\"\n", "7", "", "\xff"}) {
    scene.groups[0].prims.push_back(scene.groups[0].prims[0]);
    scene.groups[0].prims.back().name = name;
  }
  const std::string text = *WriteUsda(scene);
  EXPECT_THAT(text, HasSubstr("def Xform \"K_u00FCche_u0020_u00222_u0022_u000A\""));
  EXPECT_THAT(text, HasSubstr("def Xform \"K_u00FCche_u0020_u00222_u0022_u000A_2\""));
  EXPECT_THAT(text, HasSubstr("def Xform \"_7\""));
  EXPECT_THAT(text, HasSubstr("def Xform \"_\""));
  EXPECT_THAT(text, HasSubstr("def Xform \"_uFFFD\""));
  EXPECT_THAT(text, HasSubstr("displayName = \"Küche \\\"2\\\"\\n\""));
}

TEST(WriteUsda, PhysicsOfFreeAndFixedThings) {
  UsdScene scene = OnePrim("chair");
  RigidBody body;
  body.free = true;
  body.mass_kg = 4.5;
  body.pieces = {Tetrahedron()};
  scene.groups[0].prims[0].body = body;
  const std::string text = *WriteUsda(scene);
  EXPECT_THAT(text, HasSubstr("PhysicsRigidBodyAPI"));
  EXPECT_THAT(text, HasSubstr("float physics:mass = 4.5"));
  EXPECT_THAT(text, HasSubstr("physics:approximation = \"convexHull\""));
  scene.groups[0].prims[0].body->free = false;
  const std::string fixed = *WriteUsda(scene);
  EXPECT_THAT(fixed, Not(HasSubstr("PhysicsRigidBodyAPI")));
  EXPECT_THAT(fixed, HasSubstr("PhysicsCollisionAPI"));
}

TEST(WriteUsda, BearsWhatIsEmptyAndRefusesWhatIsBroken) {
  EXPECT_TRUE(WriteUsda({}).ok());
  UsdScene scene = OnePrim("chair_03");
  scene.groups[0].prims[0].mesh = {};
  EXPECT_THAT(*WriteUsda(scene), Not(HasSubstr("def Mesh")));
  const auto message = [](const UsdScene& broken) {
    const Result<std::string> text = WriteUsda(broken);
    EXPECT_FALSE(text.ok());
    return text.ok() ? std::string() : text.error().message;
  };
  scene = OnePrim("chair_03");
  scene.groups[0].prims[0].mesh.faces.push_back({0, 1, 4});
  EXPECT_THAT(message(scene), HasSubstr("chair_03: a face has vertex 4 of 4"));
  scene = OnePrim("chair_03");
  scene.groups[0].prims[0].mesh.vertices[2].y() = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THAT(message(scene), HasSubstr("chair_03: a vertex is not finite"));
  scene = OnePrim("chair_03");
  scene.groups[0].prims[0].world_from_prim.translation_m.x() =
      std::numeric_limits<double>::infinity();
  EXPECT_THAT(message(scene), HasSubstr("chair_03: its pose is not finite"));
}

}  // namespace
}  // namespace deepslam::usd
