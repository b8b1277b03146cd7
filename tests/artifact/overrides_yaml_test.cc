#include "deepslam/artifact/overrides_yaml.h"

#include <gmock/gmock.h>

namespace deepslam::artifact {
namespace {

using testing::HasSubstr;

Overrides Parsed(const std::string& text) {
  const Result<Overrides> overrides = DecodeOverrides(text, "overrides.yaml");
  EXPECT_TRUE(overrides.ok()) << overrides.error().message;
  return *overrides;
}

TEST(DecodeOverrides, FindsEveryFaultWithItsLine) {
  const auto overrides = DecodeOverrides(
      "version: 2\n"
      "dorp: [1]\n"
      "drop: [-1, 1, 1]\n"
      "merge: [[1]]\n"
      "split: [{object: 2, frames: [3]}]\n"
      "choose: [1]\n"
      "ground: {height_m: -1}\n",
      "o.yaml");
  ASSERT_FALSE(overrides.ok());
  EXPECT_EQ(overrides.error().code, ErrorCode::kInvalidConfig);
  for (const char* part : {"o.yaml:1: version",
                           "o.yaml:2: unknown key \"dorp\"; known are version, drop",
                           "o.yaml:3: \"-1\" is no object",
                           "o.yaml:3: object 1 stands twice",
                           "o.yaml:4: must be a list of two",
                           "o.yaml:5: unknown key \"frames\"; known are object, at_frames",
                           "o.yaml:6: must be a map",
                           "o.yaml:7: height_m"}) {
    EXPECT_THAT(overrides.error().message, HasSubstr(part));
  }
  EXPECT_FALSE(DecodeOverrides("drop: [", "o.yaml").ok());
  EXPECT_FALSE(DecodeOverrides("- 1", "o.yaml").ok());
  EXPECT_TRUE(DecodeOverrides("# nothing yet\n", "o.yaml").ok());
  EXPECT_TRUE(DecodeOverrides("", "o.yaml").ok());
}

TEST(OverridesText, CommentsAndOrderOfKeysChangeNothing) {
  const Overrides a = Parsed("drop: [4, 1]\nrelabel: {2: chair, 3: table}\n");
  const Overrides b = Parsed("# why\nrelabel:\n  table_03: table\n  2: chair\ndrop: [1, 4]\n");
  EXPECT_EQ(TrackOverridesText(a), TrackOverridesText(b));
  EXPECT_NE(TrackOverridesText(a), TrackOverridesText(Parsed("drop: [4]")));
}

// Else a stage that stands would hide that the name is wrong.
TEST(OverridesText, NamesThatHaveToBeCheckedAreInTheirText) {
  EXPECT_NE(TrackOverridesText(Parsed("drop: [4]")), TrackOverridesText(Parsed("drop: [sofa_04]")));
  EXPECT_EQ(TrackOverridesText(Parsed("drop: [chair_4, chair_01]")),
            TrackOverridesText(Parsed("drop: [chair_01, chair_04]")));
  EXPECT_NE(ChoiceOverridesText(Parsed("choose: {1: 8}")),
            ChoiceOverridesText(Parsed("choose: {chair_01: 8}")));
  EXPECT_NE(TrackOverridesText(Parsed("relabel: {1: table}")),
            TrackOverridesText(Parsed("relabel: {1: table}\nchoose: {chair_01: 5}")));
}

}  // namespace
}  // namespace deepslam::artifact
