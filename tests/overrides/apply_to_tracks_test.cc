#include "deepslam/overrides/apply_to_tracks.h"

#include <gmock/gmock.h>

#include "overrides/sample_objects.h"

namespace deepslam::overrides {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

std::vector<int> Frames(const ObjectTrack& track) {
  std::vector<int> frames;
  for (const TrackMember& member : track.members) frames.push_back(member.frame.value);
  return frames;
}

TEST(ApplyToTracks, MergesSplitsRelabelsAndDrops) {
  Association merged = ThreeObjects();
  ASSERT_TRUE(ApplyToTracks(Parsed("merge: [[0, chair_03]]"), Classes(), merged).ok());
  ASSERT_EQ(merged.tracks.size(), 2U);
  EXPECT_EQ(merged.tracks[0].id.value, 0);
  EXPECT_THAT(Frames(merged.tracks[0]), ElementsAre(0, 10, 20, 30, 40));

  Association split = ThreeObjects();
  ASSERT_TRUE(
      ApplyToTracks(Parsed("split: [{object: 0, at_frames: [10, 15]}]"), Classes(), split).ok());
  ASSERT_EQ(split.tracks.size(), 5U);
  EXPECT_THAT(Frames(split.tracks[0]), ElementsAre(0));
  EXPECT_EQ(split.tracks[3].id.value, 6);
  EXPECT_THAT(Frames(split.tracks[3]), ElementsAre(10));
  EXPECT_EQ(split.tracks[4].id.value, 7);
  EXPECT_THAT(Frames(split.tracks[4]), ElementsAre(20));
  EXPECT_EQ(split.tracks[4].class_name, "chair");

  Association relabelled = ThreeObjects();
  ASSERT_TRUE(ApplyToTracks(Parsed("relabel: {3: table}"), Classes(), relabelled).ok());
  EXPECT_EQ(relabelled.tracks[1].class_name, "table");

  Association dropped = ThreeObjects();
  const auto applied = ApplyToTracks(Parsed("drop: [5]"), Classes(), dropped);
  ASSERT_TRUE(applied.ok());
  EXPECT_THAT(*applied, ElementsAre(HasSubstr("object 5")));
  EXPECT_EQ(dropped.tracks.size(), 2U);
  ASSERT_EQ(dropped.rejections.size(), 2U);  // its detections are accounted for
  EXPECT_THAT(dropped.rejections[0].reason, HasSubstr("hand"));
}

TEST(ApplyToTracks, DoesNothingWithoutOverrides) {
  Association association = ThreeObjects();
  const auto applied = ApplyToTracks({}, Classes(), association);
  ASSERT_TRUE(applied.ok());
  EXPECT_THAT(*applied, IsEmpty());
  EXPECT_EQ(association.tracks.size(), 3U);
}

TEST(ApplyToTracks, NamesTheLineAndWhatIsKnown) {
  const auto fault = [](const std::string& text) {
    Association association = ThreeObjects();
    const auto applied = ApplyToTracks(Parsed(text), Classes(), association);
    EXPECT_FALSE(applied.ok()) << text;
    if (applied.ok()) return std::string();
    EXPECT_EQ(applied.error().code, ErrorCode::kInvalidConfig);
    return applied.error().message;
  };
  EXPECT_THAT(fault("# first\ndrop:\n  - 0\n  - 9\n"),
              testing::AllOf(HasSubstr("overrides.yaml:4"),
                             HasSubstr("no object 9"),
                             HasSubstr("0 (chair), 3 (chair), 5 (table)")));
  EXPECT_THAT(fault("relabel: {3: sofa}"), HasSubstr("known are chair, table"));
  EXPECT_THAT(fault("merge: [[0, 8]]"), HasSubstr("no object 8"));
  EXPECT_THAT(fault("split: [{object: 0, at_frames: [21]}]"), HasSubstr("0, 10, 20"));
  EXPECT_THAT(fault("split: [{object: 0, at_frames: [0]}]"), HasSubstr("one side"));
  EXPECT_THAT(fault("merge: [[0, 3]]\ndrop: [3]"), HasSubstr("dropped as well"));
}

TEST(ApplyToTracks, RefusesNamesOfOtherObjects) {
  const auto applied = [](const std::string& text) {
    Association association = ThreeObjects();
    return ApplyToTracks(Parsed(text), Classes(), association);
  };
  for (const char* text : {"drop:\n  - table_03",
                           "merge:\n  - [0, table_03]",
                           "merge:\n  - [table_03, 0]",
                           "split:\n  - {object: table_03, at_frames: [40]}",
                           "relabel:\n  table_03: chair",
                           "relabel: {3: lamp}\ndrop: [table_03]"}) {
    const auto result = applied(text);
    ASSERT_FALSE(result.ok()) << text;
    EXPECT_EQ(result.error().code, ErrorCode::kInvalidConfig);
    EXPECT_THAT(result.error().message,
                testing::AllOf(HasSubstr("overrides.yaml:2: there is no object table_03"),
                               HasSubstr("object 3 is called chair_03 (write 3"),
                               HasSubstr("known are 0 (chair), 3 (chair), 5 (table)")));
  }
  // Under its own name, as it was found or as the file relabels it, whatever the digits.
  for (const char* text : {"drop: [chair_03, chair_0, table_005]",
                           "relabel: {5: chair}\nmerge: [[0, table_05]]",
                           "relabel: {table_05: chair}\ndrop: [chair_05]"}) {
    EXPECT_TRUE(applied(text).ok()) << text;
  }
  EXPECT_THAT(applied("drop: [table_09]").error().message, HasSubstr("no object 9"));
  EXPECT_FALSE(artifact::DecodeOverrides("drop: [_03]", "o.yaml").ok());
}

}  // namespace
}  // namespace deepslam::overrides
