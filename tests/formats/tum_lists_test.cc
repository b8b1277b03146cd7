#include "deepslam/formats/tum_lists.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include "deepslam/core/random.h"
#include "support/pose_matchers.h"

namespace deepslam::formats {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::Field;
using testing::HasSubstr;
using testing::IsEmpty;

std::string Refusal(const std::string& text) {
  std::vector<std::string> warnings;
  const Result<std::vector<dataset::TimedFile>> files = ParseFileList(text, "rgb.txt", warnings);
  return files.ok() ? "" : files.error().message;
}

std::string PoseRefusal(const std::string& text) {
  std::vector<std::string> warnings;
  const Result<std::vector<TimedPose>> poses = ParsePoses(text, "groundtruth.txt", warnings);
  return poses.ok() ? "" : poses.error().message;
}

TEST(ParseFileList, ReadsForeignLineEndsMarksTabsAndCommas) {
  std::vector<std::string> warnings;
  const auto files = ParseFileList(
      "\xEF\xBB\xBF# time file\r\n\r\n1.5\trgb/a.png\r\n  2.5,rgb/b.png", "rgb.txt", warnings);
  ASSERT_TRUE(files.ok()) << files.error().message;
  EXPECT_THAT(*files,
              ElementsAre(AllOf(Field(&dataset::TimedFile::time_s, 1.5),
                                Field(&dataset::TimedFile::file, "rgb/a.png"),
                                Field(&dataset::TimedFile::line, 3)),
                          AllOf(Field(&dataset::TimedFile::time_s, 2.5),
                                Field(&dataset::TimedFile::file, "rgb/b.png"))));
  EXPECT_THAT(warnings, IsEmpty());
}

TEST(ParseFileList, SortsAndDropsRepeatedTimesAndSaysSo) {
  std::vector<std::string> warnings;
  const auto files = ParseFileList("3 c\n1 a\n2 b\n1 other\n", "rgb.txt", warnings);
  ASSERT_TRUE(files.ok());
  EXPECT_THAT(*files,
              ElementsAre(Field(&dataset::TimedFile::file, "a"),
                          Field(&dataset::TimedFile::file, "b"),
                          Field(&dataset::TimedFile::file, "c")));
  EXPECT_THAT(
      warnings,
      ElementsAre(AllOf(HasSubstr("rgb.txt"), HasSubstr("sorted")), HasSubstr("1 lines repeat")));
}

// Two recordings that overlap in time, as lines "time NAMEk".
std::string TwoSegments(const std::string& first, const std::string& second, double late_s = 0) {
  std::string text = "# time file\n";
  for (int k = 0; k < 8; ++k) text += fmt::format("{:.3f} {}{}\n", 10 + late_s + 0.1 * k, first, k);
  for (int k = 0; k < 8; ++k)
    text += fmt::format("{:.3f} {}{}\n", 10.42 + late_s + 0.1 * k, second, k);
  return text;
}

TEST(ParseFileList, KeepsTheOrderOfTheFileWhereTheClockWasSetBack) {
  std::vector<std::string> warnings;
  const auto files = ParseFileList(TwoSegments("a", "b"), "rgb.txt", warnings);
  ASSERT_TRUE(files.ok());
  ASSERT_EQ(files->size(), 16U);
  for (std::size_t k = 0; k < 16; ++k) {
    EXPECT_EQ((*files)[k].file, fmt::format("{}{}", k < 8 ? "a" : "b", k % 8));
    EXPECT_EQ((*files)[k].clock_segment, k < 8 ? 0 : 1);
  }
  EXPECT_THAT(warnings,
              ElementsAre(AllOf(HasSubstr("rgb.txt:10: the time falls back from 10.7 to 10.42 s"),
                                HasSubstr("order of the file is kept"))));
}

TEST(ParseFileList, LinesWrittenTwiceAreNoClockThatWasSetBack) {
  const std::string once = "0.0 a\n0.1 b\n0.2 c\n0.3 d\n0.4 e\n0.5 f\n";
  std::vector<std::string> warnings;
  const auto files = ParseFileList(once + once, "rgb.txt", warnings);
  ASSERT_TRUE(files.ok());
  EXPECT_EQ(files->size(), 6U);
  EXPECT_THAT(warnings, ElementsAre(HasSubstr("6 lines repeat")));
}

TEST(ParseFileList, RefusesTimesThatAreMostlyOne) {
  std::vector<std::string> warnings;
  const auto files = ParseFileList("7 a\n7 b\n7 c\n7 d\n8 e\n", "rgb.txt", warnings);
  ASSERT_FALSE(files.ok());
  EXPECT_THAT(files.error().message, HasSubstr("rgb.txt: 5 different lines have 2 times"));
  EXPECT_TRUE(ParseFileList("7 a\n7 b\n8 c\n8 d\n", "rgb.txt", warnings).ok());
  EXPECT_TRUE(
      ParsePoses("7 0 0 0 0 0 0 1\n7 1 0 0 0 0 0 1\n7 2 0 0 0 0 0 1\n", "poses.txt", warnings).ok())
      << "a run may do without poses";
}

TEST(AssociateByTime, PairsWithinSegmentsOfTheClock) {
  std::vector<std::string> warnings;
  const auto colour = ParseFileList(TwoSegments("rgb/a", "rgb/b"), "rgb.txt", warnings);
  const auto depth = ParseFileList(TwoSegments("depth/a", "depth/b", 0.015), "depth.txt", warnings);
  // The images of the other segment, 0.02 s apart, are nearer.
  const std::vector<dataset::ImagePair> pairs = AssociateByTime(*colour, *depth, 0.03);
  ASSERT_EQ(pairs.size(), 16U);
  for (const dataset::ImagePair& pair : pairs)
    EXPECT_EQ(pair.colour.file.substr(4), pair.depth.file.substr(6));
}

TEST(ParseFileList, RefusesBrokenLinesByNumber) {
  EXPECT_THAT(Refusal(""), HasSubstr("rgb.txt: lists no images"));
  EXPECT_THAT(Refusal("# only words\n"), HasSubstr("lists no images"));
  EXPECT_THAT(Refusal("1 a\n2\n"),
              AllOf(HasSubstr("rgb.txt:2:"), HasSubstr("1 fields, expected 2")));
  EXPECT_THAT(Refusal("1 a b\n"), HasSubstr("rgb.txt:1:"));
  EXPECT_THAT(Refusal("soon a\n"), AllOf(HasSubstr("rgb.txt:1:"), HasSubstr("'time' is 'soon'")));
  EXPECT_THAT(Refusal("1 a\nnan b\n"), HasSubstr("rgb.txt:2:"));
  EXPECT_THAT(Refusal("1e300 b\n"), HasSubstr("'time'"));
  EXPECT_THAT(Refusal("12abc b\n"), HasSubstr("'12abc'"));
}

TEST(ParseFileList, RefusesNamesThatLeaveTheCapture) {
  for (const char* name :
       {"/etc/hostname", "../other/a.png", "rgb/../../a.png", "..", "rgb\\a.png"}) {
    EXPECT_THAT(Refusal(std::string("1 ok.png\n2 ") + name + "\n"),
                AllOf(HasSubstr("rgb.txt:2:"), HasSubstr("'file'"), HasSubstr(name)));
  }
  EXPECT_EQ(Refusal("1 ./rgb//..a.png\n"), "");
}

TEST(ParseFileList, SurvivesArbitraryBytes) {
  Random random(1);
  for (int round = 0; round < 2000; ++round) {
    std::string text = "1 a\n2 b\n3.5 rgb/c.png\n";
    for (int i = 0; i < 4; ++i)
      text[random.Index(text.size())] = static_cast<char>(random.Index(256));
    std::vector<std::string> warnings;
    const auto files = ParseFileList(text, "rgb.txt", warnings);
    if (!files.ok()) {
      EXPECT_THAT(files.error().message, HasSubstr("rgb.txt"));
      continue;
    }
    for (std::size_t i = 1; i < files->size(); ++i)
      EXPECT_LT((*files)[i - 1].time_s, (*files)[i].time_s);
  }
}

TEST(ParseAssociations, RefusesBrokenLines) {
  std::vector<std::string> warnings;
  const auto broken =
      ParseAssociations("1 rgb/a 1 depth/a\n2 rgb/b 2\n", "associations.txt", warnings);
  ASSERT_FALSE(broken.ok());
  EXPECT_THAT(broken.error().message,
              AllOf(HasSubstr("associations.txt:2:"), HasSubstr("3 fields, expected 4")));
}

TEST(ParsePoses, LeavesOutUntrackedMomentsAndRefusesBrokenLines) {
  std::vector<std::string> warnings;
  const auto poses =
      ParsePoses("0 1 2 3 0 0 0 1.1\n1 nan nan nan 0 0 0 1\n2 0 0 0 0 0 0 0\n3 0 0 0 0 0 0 1\n",
                 "groundtruth.txt",
                 warnings);
  ASSERT_TRUE(poses.ok()) << poses.error().message;
  ASSERT_EQ(poses->size(), 2u);
  EXPECT_NEAR(poses->front().world_from_camera.rotation.norm(), 1.0, 1e-12);
  EXPECT_THAT(warnings, ElementsAre(AllOf(HasSubstr("groundtruth.txt:2"), HasSubstr("2 poses"))));
  EXPECT_THAT(PoseRefusal("0 1 2 3 0 0 0\n"),
              AllOf(HasSubstr("groundtruth.txt:1:"), HasSubstr("7 fields")));
  EXPECT_THAT(PoseRefusal("0 1 2 3 0 0 0 1\n1 1 2 x 0 0 0 1\n"),
              AllOf(HasSubstr("groundtruth.txt:2:"), HasSubstr("'tz' is 'x'")));
}

TEST(AssociateByTime, PairsAreMutuallyNearestAndWithinTolerance) {
  Random random(3);
  for (int round = 0; round < 50; ++round) {
    std::vector<dataset::TimedFile> colour, depth;
    double a = 0, b = 0;
    for (int i = 0; i < 60; ++i) {
      colour.push_back({a += random.Uniform(0.005, 0.06), "c", i});
      depth.push_back({b += random.Uniform(0.005, 0.06), "d", i});
    }
    const auto distance = [](double t, const std::vector<dataset::TimedFile>& list) {
      double best = 1e9;
      for (const dataset::TimedFile& f : list) best = std::min(best, std::abs(f.time_s - t));
      return best;
    };
    for (const dataset::ImagePair& pair : AssociateByTime(colour, depth, 0.02)) {
      const double apart_s = std::abs(pair.colour.time_s - pair.depth.time_s);
      EXPECT_LE(apart_s, 0.02);
      EXPECT_EQ(apart_s, distance(pair.depth.time_s, colour));
      EXPECT_EQ(apart_s, distance(pair.colour.time_s, depth));
    }
  }
  EXPECT_THAT(AssociateByTime({}, {{1, "d", 1}}, 1), IsEmpty());
}

TEST(PoseAt, FollowsAConstantMotionExactly) {
  const Vector6d speed = (Vector6d() << 0.3, -0.2, 0.1, 0, 0, 0.9).finished();
  std::vector<TimedPose> poses;
  for (int i = 0; i <= 10; ++i) {
    poses.push_back(
        {0.05 * i,
         Pose3{RotationFromVector(speed.tail<3>() * 0.05 * i), speed.head<3>() * 0.05 * i}});
  }
  for (const double t : {0.0, 0.013, 0.05, 0.222, 0.499}) {
    const std::optional<Pose3> at = PoseAt(poses, t, 0.02, 0.1);
    ASSERT_TRUE(at.has_value());
    EXPECT_THAT(
        *at,
        testing_support::PoseNear(
            Pose3{RotationFromVector(speed.tail<3>() * t), speed.head<3>() * t}, 1e-9, 1e-6));
  }
  EXPECT_FALSE(PoseAt(poses, 0.53, 0.02, 0.1).has_value());
  EXPECT_TRUE(PoseAt(poses, 0.51, 0.02, 0.1).has_value());
  EXPECT_FALSE(PoseAt({}, 0, 1, 1).has_value());
}

TEST(PoseAt, DoesNotInterpolateAcrossGaps) {
  const std::vector<TimedPose> poses = {{0, Pose3()},
                                        {1, Pose3{Eigen::Quaterniond::Identity(), {8, 0, 0}}}};
  EXPECT_FALSE(PoseAt(poses, 0.5, 0.02, 0.1).has_value());
  EXPECT_EQ(PoseAt(poses, 0.99, 0.02, 0.1)->translation_m.x(), 8);
}

}  // namespace
}  // namespace deepslam::formats
