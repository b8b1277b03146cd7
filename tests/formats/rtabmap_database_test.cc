#include "deepslam/formats/rtabmap_database.h"

#include <cstring>

#include <gmock/gmock.h>
#include <sqlite3.h>

#include "deepslam/core/random.h"
#include "support/temp_dir.h"

namespace deepslam::formats {
namespace {

using testing::HasSubstr;
using testing_support::TempDir;
using testing_support::WriteText;

template <typename T>
void Append(std::string& bytes, const std::vector<T>& values) {
  const std::size_t begin = bytes.size();
  bytes.resize(begin + values.size() * sizeof(T));
  std::memcpy(bytes.data() + begin, values.data(), values.size() * sizeof(T));
}

// Version, kind, size, and how many numbers K, D, R, P and the transform have.
std::string Serialised(const std::vector<double>& d, const std::vector<double>& p) {
  std::string bytes;
  Append<std::int32_t>(bytes,
                       {0,
                        20,
                        8,
                        0,
                        640,
                        480,
                        9,
                        static_cast<std::int32_t>(d.size()),
                        0,
                        static_cast<std::int32_t>(p.size()),
                        12});
  Append<double>(bytes, {525, 0, 319, 0, 526, 239, 0, 0, 1});
  Append<double>(bytes, d);
  Append<double>(bytes, p);
  Append<float>(bytes, {0, 0, 1, 0.5F, -1, 0, 0, 0.25F, 0, -1, 0, 1});
  return bytes;
}

TEST(ParseNodeCamera, ReadsCameraLensAndPlaceOnTheBase) {
  const auto plain = ParseNodeCamera(Serialised({0.1, -0.2, 0.001, 0.002, 0.05}, {}));
  ASSERT_TRUE(plain.ok()) << plain.error().message;
  EXPECT_EQ(plain->camera, (PinholeCamera{640, 480, 525, 526, 319, 239}));
  EXPECT_EQ(plain->lens,
            (LensDistortion{LensModel::kRadialTangential, {0.1, -0.2, 0.001, 0.002, 0.05}}));
  // The optical axis (z) is the base's x; what is to the right is the base's -y.
  EXPECT_LT(
      (plain->base_from_camera * Eigen::Vector3d(0, 0, 2) - Eigen::Vector3d(2.5, 0.25, 1)).norm(),
      1e-6);
  EXPECT_LT(
      (plain->base_from_camera * Eigen::Vector3d(1, 0, 0) - Eigen::Vector3d(0.5, -0.75, 1)).norm(),
      1e-6);
}

TEST(ParseNodeCamera, ImagesThatWereRectifiedHaveTheProjectionsCamera) {
  const auto read =
      ParseNodeCamera(Serialised({0.1, 0, 0, 0, 0}, {500, 0, 310, 0, 0, 501, 230, 0, 0, 0, 1, 0}));
  ASSERT_TRUE(read.ok());
  EXPECT_EQ(read->camera, (PinholeCamera{640, 480, 500, 501, 310, 230}));
  EXPECT_FALSE(read->lens.has_value());
}

TEST(ParseNodeCamera, FisheyeHasSixNumbers) {
  const auto read = ParseNodeCamera(Serialised({0.1, 0.2, 0, 0, 0.3, 0.4}, {}));
  ASSERT_TRUE(read.ok());
  EXPECT_EQ(read->lens, (LensDistortion{LensModel::kFisheye, {0.1, 0.2, 0.3, 0.4}}));
}

TEST(ParseNodeCamera, CutAndDamagedBytesAreRefused) {
  const std::string whole = Serialised({0.1, 0, 0, 0, 0}, {});
  for (std::size_t size = 0; size < whole.size(); ++size)
    EXPECT_FALSE(ParseNodeCamera(std::string_view(whole).substr(0, size)).ok()) << size;
  EXPECT_THAT(ParseNodeCamera(whole + whole).error().message, HasSubstr("several cameras"));
  Random random(6);
  for (int trial = 0; trial < 5000; ++trial) {
    std::string bytes = whole;
    for (int k = 0; k < 4; ++k)
      bytes[random.Index(bytes.size())] = static_cast<char>(random.Index(256));
    (void)ParseNodeCamera(bytes).ok();
  }
}

TEST(RtabMapDatabase, OtherFilesAreNone) {
  const TempDir dir;
  WriteText(dir.path() / "text.db", "SQLite format 3, or so");
  sqlite3* other = nullptr;
  ASSERT_EQ(sqlite3_open((dir.path() / "other.db").c_str(), &other), SQLITE_OK);
  sqlite3_exec(other, "CREATE TABLE topics (id INTEGER)", nullptr, nullptr, nullptr);
  sqlite3_close(other);
  for (const char* name : {"text.db", "other.db"}) {
    const auto database = RtabMapDatabase::Open(dir.path() / name);
    const auto nodes =
        database.ok() ? (*database)->Nodes() : Result<std::vector<Node>>(database.error());
    ASSERT_FALSE(nodes.ok()) << name;
    EXPECT_THAT(nodes.error().message, testing::AllOf(HasSubstr(name), HasSubstr("RTAB-Map")));
  }
  EXPECT_FALSE(RtabMapDatabase::Open(dir.path() / "nowhere.db").ok());
}

}  // namespace
}  // namespace deepslam::formats
