#include "deepslam/formats/pose_texts.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include "deepslam/core/random.h"
#include "deepslam/formats/text_lines.h"
#include "support/pose_matchers.h"
#include "support/temp_dir.h"

namespace deepslam::formats {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;
using testing_support::PoseNear;
using testing_support::TempDir;
using testing_support::WriteText;

Pose3 SomePose(Random& random) {
  const auto number = [&] { return 4 * random.Uniform() - 2; };
  return {RotationFromVector({number(), number(), number()}), {number(), number(), number()}};
}

std::string Line(const Pose3& pose, PoseColumns columns) {
  const Eigen::Vector3d& t = pose.translation_m;
  const Eigen::Quaterniond& q = pose.rotation;
  if (columns == PoseColumns::kXyzQuatXyzw)
    return fmt::format("{} {} {} {} {} {} {}\n", t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w());
  if (columns == PoseColumns::kXyzQuatWxyz)
    return fmt::format("{} {} {} {} {} {} {}\n", t.x(), t.y(), t.z(), q.w(), q.x(), q.y(), q.z());
  const Eigen::Matrix3d r = q.toRotationMatrix();
  std::string line;
  for (int row = 0; row < 3; ++row)
    line += fmt::format("{} {} {} {} ", r(row, 0), r(row, 1), r(row, 2), t[row]);
  return line + "0 0 0 1\n";
}

TEST(ParsePoseLines, ReadsEveryColumnOrder) {
  Random random(3);
  for (const PoseColumns columns :
       {PoseColumns::kMatrix, PoseColumns::kXyzQuatXyzw, PoseColumns::kXyzQuatWxyz}) {
    std::string text = "# poses\n";
    std::vector<Pose3> truth;
    for (int i = 0; i < 5; ++i) {
      truth.push_back(SomePose(random));
      text += Line(truth.back(), columns);
    }
    std::vector<std::string> warnings;
    const Result<FramePoses> poses = ParsePoseLines(text, "p.txt", columns, warnings);
    ASSERT_TRUE(poses.ok()) << poses.error().message;
    ASSERT_EQ(poses->size(), 5U);
    EXPECT_THAT(warnings, IsEmpty());
    for (std::size_t i = 0; i < 5; ++i) {
      ASSERT_TRUE((*poses)[i].has_value());
      EXPECT_THAT(*(*poses)[i], PoseNear(truth[i], 1e-9, 1e-6));
    }
  }
}

TEST(ParsePoseLines, LeavesOutWhatIsNoPoseAndTheUnfinishedLine) {
  std::vector<std::string> warnings;
  const Result<FramePoses> poses =
      ParsePoseLines("0 0 0 0 0 0 1\nnan 0 0 0 0 0 1\n0 0 0 0 0 0 0\n1 0 0 0 0 0 1\n2 0 0 0",
                     "p.txt",
                     PoseColumns::kXyzQuatXyzw,
                     warnings);
  ASSERT_TRUE(poses.ok());
  // The frame of the unfinished line has none, as those of the others.
  ASSERT_EQ(poses->size(), 5U);
  EXPECT_TRUE((*poses)[0] && !(*poses)[1] && !(*poses)[2] && (*poses)[3] && !(*poses)[4]);
  EXPECT_THAT(warnings, Contains(AllOf(HasSubstr("p.txt:2"), HasSubstr("2 poses"))));
  EXPECT_THAT(warnings, Contains(AllOf(HasSubstr("p.txt:5"), HasSubstr("left out"))));
}

TEST(ParsePoseLines, RefusesBrokenLinesByNumber) {
  std::vector<std::string> warnings;
  for (const auto& [text, fault] :
       {std::pair<std::string, std::string>("0 0 0 0 0 1\n", "6 fields"),
        {"0 0 zero 0 0 0 1\n", "'zero'"},
        {"0 0 0 0 0 0 1 7 7\n", "9 fields"}}) {
    const auto poses =
        ParsePoseLines("0 0 0 0 0 0 1\n" + text, "p.txt", PoseColumns::kXyzQuatXyzw, warnings);
    ASSERT_FALSE(poses.ok()) << text;
    EXPECT_THAT(poses.error().message, AllOf(HasSubstr("p.txt:2"), HasSubstr(fault)));
  }
}

TEST(ParsePoseLines, SurvivesArbitraryBytes) {
  Random random(4);
  const std::string alphabet("0123456789.-+eE naif\n\t,#\0", 25);
  for (int trial = 0; trial < 3000; ++trial) {
    std::string text(random.Index(120), ' ');
    for (char& c : text) c = alphabet[random.Index(alphabet.size())];
    std::vector<std::string> warnings;
    const auto poses = ParsePoseLines(text, "p.txt", PoseColumns::kMatrix, warnings);
    if (!poses.ok()) {
      EXPECT_THAT(poses.error().message, HasSubstr("p.txt"));
    }
  }
}

TEST(OfOpenGlCamera, PointsBeforeTheCameraStayWhereTheyAre) {
  Random random(5);
  for (int trial = 0; trial < 20; ++trial) {
    const Pose3 world_from_gl = SomePose(random);
    // A point below, right of and before the camera: y down and z forward, or y up and z back.
    const Eigen::Vector3d p_camera(0.3, 0.2, 1.5), p_gl(0.3, -0.2, -1.5);
    EXPECT_LT((OfOpenGlCamera(world_from_gl) * p_camera - world_from_gl * p_gl).norm(), 1e-9);
  }
}

TEST(ReadMatrixFiles, MissingAndLostFilesAreNoPoses) {
  const TempDir dir;
  WriteText(dir.path() / "0.txt", "1 0 0 4\n0 1 0 5\n0 0 1 6\n0 0 0 1\n");
  WriteText(dir.path() / "2.txt",
            "-inf -inf -inf -inf\n-inf -inf -inf -inf\n-inf -inf -inf -inf\n0 0 0 1\n");
  std::vector<std::string> warnings;
  const auto read = ReadMatrixFiles(dir.path(), {"0.txt", "1.txt", "2.txt"}, warnings);
  ASSERT_TRUE(read.ok()) << read.error().message;
  ASSERT_EQ(read->poses.size(), 3U);
  EXPECT_EQ(read->poses[0]->translation_m, Eigen::Vector3d(4, 5, 6));
  EXPECT_FALSE(read->poses[1] || read->poses[2]);
  EXPECT_THAT(warnings, Contains(HasSubstr("2.txt")));
  WriteText(dir.path() / "1.txt", "1 0 0\n");
  EXPECT_THAT(ReadMatrixFiles(dir.path(), {"1.txt"}, warnings).error().message,
              AllOf(HasSubstr("1.txt"), HasSubstr("3 numbers")));
  EXPECT_FALSE(ReadMatrixFiles(dir.path(), {"1.txt", "0.txt"}, warnings).ok());
  const auto last = ReadMatrixFiles(dir.path(), {"0.txt", "1.txt"}, warnings);
  ASSERT_TRUE(last.ok());
  ASSERT_EQ(last->poses.size(), 2U);
  EXPECT_TRUE(last->poses[0] && !last->poses[1]);
  EXPECT_THAT(warnings, Contains(AllOf(HasSubstr("1.txt"), HasSubstr("left out"))));
}

TEST(TimeError, NamesTheUnitThatASizeTells) {
  for (const auto& [field, unit] : {std::pair<std::string, std::string>("1403636589763", "milli"),
                                    {"1403636589763555", "micro"},
                                    {"1403636589763555000", "nano"},
                                    {"345678901234", "nano"},
                                    {"345678901234567", "nano"}}) {
    EXPECT_THAT(TimeError("rgb.txt", 3, "time", field).message,
                AllOf(HasSubstr("rgb.txt:3"), HasSubstr(field), HasSubstr(unit)));
  }
  EXPECT_THAT(TimeError("rgb.txt", 3, "time", "noon").message,
              AllOf(HasSubstr("'noon'"), HasSubstr("not a time")));
}

}  // namespace
}  // namespace deepslam::formats
