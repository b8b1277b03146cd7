#include "deepslam/formats/recognise_file.h"

#include <gmock/gmock.h>

#include "support/temp_dir.h"

namespace deepslam::formats {
namespace {

using testing::HasSubstr;
using testing_support::TempDir;
using testing_support::WriteText;

struct Stranger {
  std::string name;
  std::string file;
  std::string bytes;
  std::vector<std::string> told;
};
void PrintTo(const Stranger& stranger, std::ostream* out) { *out << stranger.name; }

class RecogniseFile : public testing::TestWithParam<Stranger> {};

// By what the bytes are, whatever the file is called.
TEST_P(RecogniseFile, SaysWhatItIsAndWhatToDo) {
  const TempDir dir;
  WriteText(dir.path() / GetParam().file, GetParam().bytes);
  const std::optional<std::string> words = WhatIsToBeDone(dir.path() / GetParam().file);
  ASSERT_TRUE(words.has_value());
  for (const std::string& part : GetParam().told) EXPECT_THAT(*words, HasSubstr(part));
}

const std::string kRest(600, 'x');

INSTANTIATE_TEST_SUITE_P(
    All,
    RecogniseFile,
    testing::Values(
        Stranger{"Gzip", "capture", "\x1f\x8b\x08" + kRest, {"gzip archive", "unpack it"}},
        Stranger{"Zip", "desk", "PK\x03\x04" + kRest, {"zip archive", "unpack it"}},
        Stranger{"Xz",
                 "a",
                 std::string("\xfd"
                             "7zXZ\0",
                             6) +
                     kRest,
                 {"xz archive"}},
        Stranger{"Zstd", "a", "\x28\xb5\x2f\xfd" + kRest, {"zstd archive"}},
        Stranger{"SevenZip", "a", "7z\xbc\xaf\x27\x1c" + kRest, {"7-Zip archive"}},
        Stranger{"Tar", "a", std::string(257, 'n') + "ustar" + kRest, {"tar archive"}},
        Stranger{"Record3d", "room.r3d", "PK\x03\x04" + kRest, {"Record3D", "import_recording.py"}},
        Stranger{"Record3dInCapitals", "ROOM.R3D", "PK\x03\x04" + kRest, {"Record3D"}},
        Stranger{"RosBag", "d435", "#ROSBAG V2.0\n" + kRest, {"ROS 1", "import_recording.py"}},
        Stranger{"Mcap", "a", "\x89MCAP0\r\n" + kRest, {"ROS 2", "import_recording.py"}},
        Stranger{"Ros2Database",
                 "run_0.db3",
                 std::string("SQLite format 3\0", 16) + "CREATE TABLE topics(id" + kRest,
                 {"ROS 2", "import_recording.py"}},
        Stranger{"Database",
                 "map.sqlite",
                 std::string("SQLite format 3\0", 16) + "CREATE TABLE Node(id" + kRest,
                 {"RTAB-Map", "rtabmap-export"}},
        Stranger{"AzureKinect",
                 "a",
                 "\x1a\x45\xdf\xa3" + kRest + "K4A_DEPTH_MODE",
                 {"Azure Kinect", "import_recording.py"}},
        Stranger{"Video", "rgb", std::string("\0\0\0\x20", 4) + "ftypisom" + kRest, {"video"}},
        Stranger{"PointCloud", "room", "ply\nformat ascii 1.0\n", {"point cloud"}},
        Stranger{"Avi", "a", std::string("RIFF\0\0\0\0", 8) + "AVI LIST" + kRest, {"video"}},
        Stranger{"Hdf5", "nyu.mat", "\x89HDF\r\n\x1a\n" + kRest, {"HDF5", "color/ and depth/"}},
        Stranger{"Matlab", "a", "MATLAB 5.0 MAT-file, Platform" + kRest, {"MATLAB"}},
        Stranger{"Zed", "HD720.SVO2", kRest, {"ZED"}},
        Stranger{"Kintinuous", "loop.klg", kRest, {"Kintinuous"}},
        Stranger{"Record3dAsZip",
                 "room.zip",
                 "PK\x03\x04" + kRest + "rgbd/0.jpg",
                 {"Record3D", "import_recording.py"}},
        Stranger{"Image", "a", "\x89PNG\r\n\x1a\n" + kRest, {"one image"}}),
    [](const auto& test) { return test.param.name; });

TEST(RecogniseFile, SaysNothingOfWhatItDoesNotKnow) {
  const TempDir dir;
  for (const std::string bytes : {"", "x", "time file\n0 a.png\n", "PK", "\x1a\x45"}) {
    WriteText(dir.path() / "file", bytes);
    EXPECT_FALSE(WhatIsToBeDone(dir.path() / "file")) << bytes;
  }
  EXPECT_FALSE(WhatIsToBeDone(dir.path() / "nowhere"));
  EXPECT_FALSE(WhatIsToBeDone(dir.path()));
}

}  // namespace
}  // namespace deepslam::formats
