#include "deepslam/artifact/map_json.h"

#include <string>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "artifact/sample_values.h"

namespace deepslam::artifact {
namespace {

using nlohmann::json;
using testing::HasSubstr;

std::string Message(const json& document) {
  const Result<CompactMap> map = DecodeMap(document.dump(), "map.json");
  return map.ok() ? "accepted" : map.error().message;
}

json SampleDocument() { return json::parse(*EncodeMap(testing_support::SampleMap(), "map.json")); }

TEST(MapJson, HasTheLayoutInTheMapsWorld) {
  const json layout = SampleDocument().at("layout");
  EXPECT_EQ(layout.at("rooms")[0].at("polygon_m"), json({0.0, 0.0, 4.125, 0.0, 4.0, 3.0}));
  EXPECT_EQ(layout.at("rooms")[0].at("id"), 0);
  EXPECT_EQ(layout.at("rooms")[0].at("ceiling_m"), 2.5);
  EXPECT_TRUE(layout.at("rooms")[1].at("ceiling_m").is_null());
  EXPECT_EQ(layout.at("walls")[1].at("id"), 1);
  EXPECT_EQ(layout.at("walls")[0].at("rooms"), json({0, 1}));
  EXPECT_EQ(layout.at("walls")[0].at("to_m"), json({4.125, 0.0}));
  EXPECT_EQ(layout.at("openings")[0].at("kind"), "window");
  EXPECT_EQ(layout.at("openings")[1].at("wall"), 1);
}

TEST(MapJson, ReadsMapsOfTheVersionBefore) {
  json old = SampleDocument();
  old["version"] = 4;
  old.erase("layout");
  for (json& object : old["objects"]) {
    for (const char* field : {"room", "stands_on", "against_wall"}) object.erase(field);
  }
  const Result<CompactMap> map = DecodeMap(old.dump(), "map.json");
  ASSERT_TRUE(map.ok()) << map.error().message;
  EXPECT_FALSE(map->layout.has_value());
  EXPECT_EQ(map->objects.size(), testing_support::SampleMap().objects.size());
  EXPECT_FALSE(map->objects[0].room.has_value());
  for (const int version : {1, 3, 6}) {
    old["version"] = version;
    EXPECT_THAT(Message(old), HasSubstr("version is " + std::to_string(version))) << version;
  }
}

// Each a value that means nothing, and the field that the message has to name.
TEST(MapJson, RefusesALayoutThatMeansNothing) {
  const auto message = [](const auto& change) {
    json document = SampleDocument();
    change(document);
    return Message(document);
  };
  EXPECT_THAT(message([](json& d) { d["layout"]["walls"][0]["rooms"] = {2}; }), HasSubstr("walls"));
  EXPECT_THAT(message([](json& d) { d["layout"]["walls"][1]["id"] = 0; }), HasSubstr("ids"));
  EXPECT_THAT(message([](json& d) { d["layout"]["openings"][0]["wall"] = 2; }),
              HasSubstr("openings"));
  EXPECT_THAT(message([](json& d) { d["layout"]["openings"][0]["kind"] = "hatch"; }),
              HasSubstr("kind"));
  EXPECT_THAT(message([](json& d) {
                d["layout"]["rooms"][0]["polygon_m"] = {0, 0, 1};
              }),
              HasSubstr("polygon_m"));
  EXPECT_THAT(message([](json& d) { d["layout"]["rooms"][0]["ceiling_m"] = -1; }),
              HasSubstr("ceiling_m"));
  EXPECT_THAT(message([](json& d) { d["layout"]["walls"][0]["top_m"] = -5; }), HasSubstr("top_m"));
  EXPECT_THAT(message([](json& d) { d["objects"][0]["room"] = 2; }), HasSubstr("chair_04"));
  EXPECT_THAT(message([](json& d) { d["objects"][1]["against_wall"] = 7; }), HasSubstr("table_05"));
  EXPECT_THAT(message([](json& d) { d.erase("layout"); }), HasSubstr("is not there"));
  EXPECT_THAT(message([](json& d) { d["layout"] = 3; }), HasSubstr("layout"));
}

}  // namespace
}  // namespace deepslam::artifact
