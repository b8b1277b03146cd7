#include "deepslam/artifact/layout_json.h"

#include <string>

#include <gmock/gmock.h>

namespace deepslam::artifact {
namespace {

using testing::HasSubstr;

Layout Sample() {
  Layout layout;
  LayoutRoom room;
  room.polygon_m = {{0, 0}, {4.125, 0}, {4, 3}, {0, 3}};
  room.guessed = {false, true, false, false};
  room.floor_m = 0.01;
  room.ceiling_m = 2.5;
  room.seen_share = 0.9;
  room.confidence = 0.8;
  room.note = "seen from outside only";
  LayoutRoom low = room;
  low.ceiling_m = 0;  // not seen
  low.note.clear();
  layout.rooms = {room, low};
  LayoutWall wall;
  wall.to_m = {4.125, 0};
  wall.top_m = 2.5;
  wall.rooms = {0, 1};
  wall.seen_share = 0.5;
  wall.confidence = 0.7;
  wall.offset_sigma_m = 0.003;
  wall.angle_sigma_rad = 0.002;
  layout.walls = {wall};
  LayoutOpening opening;
  opening.kind = OpeningKind::kWindow;
  opening.from_m = {1, 0};
  opening.to_m = {2, 0};
  opening.bottom_m = 0.9;
  opening.top_m = 2.1;
  opening.rooms = {0};
  opening.confidence = 0.4;
  opening.note = "glass?";
  layout.openings = {opening};
  layout.levels = {{LevelKind::kFloor, 0.01, 11.5}, {LevelKind::kCeiling, 2.5, 9}};
  layout.slanted = {{{Eigen::Vector3d(0, 0.6, -0.8), 1.5}, {1, 2, 2.2}, 3.5}};
  layout.level_from_tracking.translation_m = {0.5, -1, 1.4};
  layout.notes = {"a mirror"};
  return layout;
}

TEST(LayoutJson, ReadsBackWhatWasWritten) {
  const std::string text = *EncodeLayout(Sample(), "layout.json");
  const Result<Layout> read = DecodeLayout(text, "layout.json");
  ASSERT_TRUE(read.ok()) << read.error().message;
  EXPECT_EQ(*read, Sample());
  EXPECT_EQ(*EncodeLayout(*read, "layout.json"), text);
  const std::string nothing = *EncodeLayout(Layout(), "layout.json");
  EXPECT_EQ(*DecodeLayout(nothing, "layout.json"), Layout());
}

TEST(LayoutJson, RefusesWhatIsCutOffAndOtherVersions) {
  const std::string text = *EncodeLayout(Sample(), "layout.json");
  for (std::size_t length = 0; length + 2 < text.size(); length += 37)
    EXPECT_FALSE(DecodeLayout(text.substr(0, length), "layout.json").ok()) << length;
  std::string future = text;
  const std::size_t at = future.find("\"version\":");
  ASSERT_NE(at, std::string::npos);
  future.replace(future.find('1', at), 1, "7");
  EXPECT_THAT(DecodeLayout(future, "layout.json").error().message, HasSubstr("version"));
}

// Each a value that means nothing, and the field that the message has to name.
TEST(LayoutJson, RefusesNonsenseByItsField) {
  const auto message = [](const auto& change) {
    Layout layout = Sample();
    change(layout);
    const Result<Layout> read = DecodeLayout(*EncodeLayout(layout, "layout.json"), "layout.json");
    return read.ok() ? std::string("accepted") : read.error().message;
  };
  EXPECT_THAT(message([](Layout& l) { l.walls[0].rooms = {2}; }), HasSubstr("walls"));
  EXPECT_THAT(message([](Layout& l) { l.openings[0].wall = 1; }), HasSubstr("openings"));
  EXPECT_THAT(message([](Layout& l) { l.rooms[0].polygon_m.resize(2); }), HasSubstr("polygon_m"));
  EXPECT_THAT(message([](Layout& l) { l.rooms[0].guessed.pop_back(); }), HasSubstr("guessed"));
  EXPECT_THAT(message([](Layout& l) { l.walls[0].top_m = -1; }), HasSubstr("top_m"));
  EXPECT_THAT(message([](Layout& l) { l.walls[0].from_m.x() = 1e9; }), HasSubstr("from_m"));
  EXPECT_THAT(message([](Layout& l) { l.openings[0].confidence = 2; }), HasSubstr("confidence"));
}

}  // namespace
}  // namespace deepslam::artifact
