// That MuJoCo and PyBullet load the files, and that things stay where they stand, is shown in
// tests/exports.
#include "deepslam/simulator/simulator_files.h"

#include <cmath>
#include <limits>
#include <map>
#include <string>

#include <gmock/gmock.h>

#include "deepslam/simulator/xml_text.h"
#include "support/box_meshes.h"

namespace deepslam::simulator {
namespace {

using testing::HasSubstr;
using testing::Not;
using testing_support::Tetrahedron;

SimulatedThing Thing(const std::string& name, bool free) {
  SimulatedThing thing;
  thing.name = name;
  thing.mesh = Tetrahedron();
  thing.world_from_thing.translation_m = {1, 2, 0};
  thing.body.free = free;
  thing.body.mass_kg = 4.5;
  thing.body.pieces = {Tetrahedron(), Tetrahedron()};
  return thing;
}

using Files = std::map<std::string, std::string, std::less<>>;

Status WriteInto(Files& files, const SimulatorScene& scene) {
  return WriteSimulatorFiles(scene, [&](std::string_view file, std::string_view bytes) {
    EXPECT_TRUE(files.emplace(file, bytes).second) << file << " is written twice";
    return Ok();
  });
}

TEST(WriteSimulatorFiles, FreeAndFixedThings) {
  Files files;
  ASSERT_TRUE(
      WriteInto(files, {{Thing("chair_03", true), Thing("wall_00", false)}, true, "x"}).ok());
  const std::string& mjcf = files.at("scene.xml");
  EXPECT_THAT(mjcf, HasSubstr("<freejoint name=\"chair_03_joint\"/>"));
  EXPECT_THAT(mjcf, Not(HasSubstr("wall_00_joint")));
  EXPECT_THAT(mjcf, HasSubstr("type=\"plane\""));
  const std::string& urdf = files.at("scene.urdf");
  EXPECT_THAT(urdf, HasSubstr("name=\"chair_03_joint\" type=\"floating\""));
  EXPECT_THAT(urdf, HasSubstr("name=\"wall_00_joint\" type=\"fixed\""));
  EXPECT_THAT(files.at("scene_fixed.urdf"), Not(HasSubstr("chair_03")));
  const std::string& sdf = files.at("scene.sdf");
  EXPECT_THAT(sdf,
              HasSubstr("<model name=\"chair_03\">\n      <pose>1 2 0 0 0 0</pose>\n      "
                        "<static>false</static>"));
  EXPECT_THAT(sdf, HasSubstr("<static>true</static>"));
  EXPECT_THAT(sdf, HasSubstr("<mass>4.5</mass>"));
  EXPECT_THAT(files.at("objects/chair_03.urdf"), HasSubstr("../meshes/chair_03_piece_1.obj"));
  EXPECT_FALSE(files.contains("objects/wall_00.urdf"));
  EXPECT_THAT(files.at("placements.json"), HasSubstr("\"position_m\": [1, 2, 0]"));
  EXPECT_EQ(files.at("meshes/wall_00_piece_0.obj").substr(0, 10), "v 0.00000 ");
  // Every mesh that a file names is there.
  for (const char* text : {"scene.xml", "scene.urdf", "scene.sdf"}) {
    const std::string& content = files.at(text);
    for (std::size_t at = content.find(".obj"); at != std::string::npos;
         at = content.find(".obj", at + 1)) {
      const std::size_t begin = content.find_last_of("\"/", at) + 1;
      EXPECT_TRUE(files.contains("meshes/" + content.substr(begin, at + 4 - begin)));
    }
  }
}

// A link without a mass is none to sdformat, and a model without links is refused.
TEST(WriteSimulatorFiles, TheFloorAloneIsALinkWithAMass) {
  Files files;
  ASSERT_TRUE(WriteInto(files, {{Thing("chair_03", true)}, true, ""}).ok());
  const std::string& urdf = files.at("scene_fixed.urdf");
  EXPECT_THAT(urdf, Not(HasSubstr("chair_03")));
  EXPECT_THAT(urdf, HasSubstr("<mass value="));
}

TEST(WriteSimulatorFiles, NamesAreWhatTheFormatsTake) {
  Files files;
  ASSERT_TRUE(
      WriteInto(files,
                {{Thing("Stühle <1>", true), Thing("Stühle <1>", true), Thing("world", true)},
                 false,
                 "a -- b & \"c\""})
          .ok());
  EXPECT_TRUE(files.contains("objects/St_u00FChle_u0020_u003C1_u003E.urdf"));
  EXPECT_TRUE(files.contains("objects/St_u00FChle_u0020_u003C1_u003E_2.urdf"));
  EXPECT_TRUE(files.contains("objects/world_2.urdf")) << "the scene's own link is called so";
  EXPECT_THAT(files.at("scene.xml"), HasSubstr("<!-- a - - b &amp; &quot;c&quot; -->"));
  EXPECT_THAT(files.at("scene.xml"), Not(HasSubstr("plane")));
}

TEST(WriteSimulatorFiles, BearsNothingAndWhatIsSeenAlone) {
  Files files;
  ASSERT_TRUE(WriteInto(files, {}).ok());
  EXPECT_THAT(files.at("placements.json"), HasSubstr("\"objects\": []"));
  files.clear();
  SimulatedThing seen = Thing("rug", false);
  seen.body.pieces.clear();
  SimulatedThing felt = Thing("air", false);
  felt.mesh = {};
  ASSERT_TRUE(WriteInto(files, {{seen, felt}, true, ""}).ok());
  EXPECT_TRUE(files.contains("meshes/rug.obj"));
  EXPECT_FALSE(files.contains("meshes/air.obj"));
  EXPECT_TRUE(files.contains("meshes/air_piece_0.obj"));
}

TEST(WriteSimulatorFiles, RefusesWhatIsBrokenByItsName) {
  const auto message = [](const SimulatedThing& thing) {
    Files files;
    const Status status = WriteInto(files, {{thing}, true, ""});
    EXPECT_FALSE(status.ok());
    return status.ok() ? std::string() : status.error().message;
  };
  SimulatedThing thing = Thing("chair_03", true);
  thing.mesh.faces.push_back({0, 1, 9});
  EXPECT_THAT(message(thing), HasSubstr("chair_03"));
  thing = Thing("chair_03", true);
  thing.body.pieces[1].vertices[0].x() = std::numeric_limits<float>::infinity();
  EXPECT_THAT(message(thing), HasSubstr("chair_03"));
  thing = Thing("chair_03", true);
  thing.body.mass_kg = std::nan("");
  EXPECT_THAT(message(thing), HasSubstr("chair_03: its pose or its mass"));
}

TEST(WriteSimulatorFiles, TheFirstErrorOfTheWriterEndsIt) {
  int calls = 0;
  const Status status = WriteSimulatorFiles({{Thing("chair", true)}, true, ""},
                                            [&](std::string_view, std::string_view) -> Status {
                                              ++calls;
                                              return InvalidInput("disk full");
                                            });
  ASSERT_FALSE(status.ok());
  EXPECT_EQ(status.error().message, "disk full");
  EXPECT_EQ(calls, 1);
}

TEST(RollPitchYaw, TurnAsTheRotationDoes) {
  for (const Eigen::Vector3d& axis : {Eigen::Vector3d(1, 2, 3), Eigen::Vector3d(0, 1, 0)}) {
    for (const double angle : {0.0, 0.3, 1.57079632679, 2.5, -3.0}) {
      const Eigen::Quaterniond q(Eigen::AngleAxisd(angle, axis.normalized()));
      const Eigen::Vector3d rpy = RollPitchYaw(q);
      const Eigen::Quaterniond back = Eigen::AngleAxisd(rpy.z(), Eigen::Vector3d::UnitZ()) *
                                      Eigen::AngleAxisd(rpy.y(), Eigen::Vector3d::UnitY()) *
                                      Eigen::AngleAxisd(rpy.x(), Eigen::Vector3d::UnitX());
      EXPECT_NEAR(std::abs(back.dot(q)), 1, 1e-6) << angle;
    }
  }
}

}  // namespace
}  // namespace deepslam::simulator
