// ScanNet's .sens, written here field by field.
#include <gmock/gmock.h>

#include <fmt/format.h>

#include "deepslam/core/random.h"
#include "deepslam/formats/sens_codecs.h"
#include "deepslam/layouts/open_capture.h"
#include "foreign_captures.h"
#include "support/allocation_watch.h"
#include "support/pose_matchers.h"

namespace deepslam::layouts {
namespace {

namespace fs = std::filesystem;
using foreign::SensBytes;
using foreign::SensOptions;
using testing::AllOf;
using testing::Contains;
using testing::HasSubstr;
using testing_support::TempDir;
using testing_support::WriteText;

std::string Refusal(const fs::path& path) {
  const Result<dataset::Capture> capture = OpenCapture(path);
  if (capture.ok()) return "";
  EXPECT_EQ(capture.error().code, ErrorCode::kInvalidInput);
  return capture.error().message;
}

// Version, colour codec, depth codec.
class SensCodecs : public testing::TestWithParam<std::tuple<std::uint32_t, int, int>> {};

TEST_P(SensCodecs, AreAllRead) {
  const auto [version, colour, depth] = GetParam();
  const TempDir dir;
  const fs::path file = dir.path() / "scene0000_00.sens";
  WriteText(file,
            foreign::Sens({.version = version, .colour_codec = colour, .depth_codec = depth}));
  const Result<dataset::Capture> capture = OpenCapture(file);
  ASSERT_TRUE(capture.ok()) << capture.error().message;
  EXPECT_EQ(capture->format, "scannet");
  const FrameSource& frames = *capture->frames;
  ASSERT_EQ(frames.num_frames(), 3);
  EXPECT_EQ(frames.camera(), (PinholeCamera{32, 24, 30.3, 30.3, 15.5, 11.25}));
  for (int i = 0; i < 3; ++i) {
    const Result<Frame> frame = frames.Read(FrameIdx{i});
    ASSERT_TRUE(frame.ok()) << frame.error().message;
    EXPECT_DOUBLE_EQ(frame->time_s, (1000500 + 33333 * i) / 1e6);
    for (int v = 0; v < foreign::kHeight; ++v) {
      for (int u = 0; u < foreign::kWidth; ++u) {
        const int mm = depth == 2 ? formats::ShiftToMillimetres(foreign::Shift(u, v))
                                  : foreign::DepthMm(i, u, v);
        ASSERT_EQ(frame->depth_m(u, v), static_cast<float>(mm / 1000.0)) << u << ", " << v;
        const auto rgb = foreign::Rgb(i, u, v);
        ASSERT_NEAR(frame->colour(u, v).r, rgb[0], colour == 2 ? 12 : 0);
        ASSERT_NEAR(frame->colour(u, v).g, rgb[1], colour == 2 ? 12 : 0);
      }
    }
    const auto m = foreign::Matrix(i);
    Eigen::Matrix4d matrix;
    for (int k = 0; k < 16; ++k) matrix(k / 4, k % 4) = m[static_cast<std::size_t>(k)];
    EXPECT_THAT(*frames.capture_world_from_camera(FrameIdx{i}),
                testing_support::PoseNear(Pose3::FromMatrix(matrix), 1e-6, 1e-4));
  }
}

INSTANTIATE_TEST_SUITE_P(All,
                         SensCodecs,
                         testing::Combine(testing::Values(3u, 4u),
                                          testing::Values(0, 1, 2),
                                          testing::Values(0, 1, 2)));

TEST(Sens, ShiftsAreTheStructureSensorsDepths) {
  // Some of its own table.
  for (const auto& [shift, mm] : {std::pair(0, 0),
                                  {1, 264},
                                  {2, 264},
                                  {3, 265},
                                  {90, 287},
                                  {835, 1000},
                                  {859, 1087},
                                  {1059, 3956},
                                  {1100, 8612},
                                  {1104, 9729},
                                  {1105, 0},
                                  {2047, 0},
                                  {-3, 0}}) {
    EXPECT_EQ(formats::ShiftToMillimetres(shift), mm) << shift;
  }
}

TEST(Sens, LostPosesAreMinusInfinity) {
  const TempDir dir;
  WriteText(dir.path() / "a.sens", foreign::Sens({.lost_frame = 1}));
  const Result<dataset::Capture> capture = OpenCapture(dir.path());
  ASSERT_TRUE(capture.ok()) << "a folder with one .sens file: " << capture.error().message;
  EXPECT_TRUE(capture->frames->capture_world_from_camera(FrameIdx{0}));
  EXPECT_FALSE(capture->frames->capture_world_from_camera(FrameIdx{1}));
  EXPECT_TRUE(capture->frames->capture_world_from_camera(FrameIdx{2}));
}

TEST(Sens, ExtrinsicsRegisterDepthAndPosesBecomeColours) {
  const TempDir dir;
  SensOptions options;
  // x_colour = x_depth - 0.1
  options.depth_extrinsics[3] = -0.1;
  WriteText(dir.path() / "a.sens", foreign::Sens(options));
  const Result<dataset::Capture> capture = OpenCapture(dir.path() / "a.sens");
  ASSERT_TRUE(capture.ok()) << capture.error().message;
  const Frame frame = *capture->frames->ReadDepth(FrameIdx{0});
  EXPECT_NEAR(frame.depth_m(10, 10), 0.001f * foreign::DepthMm(0, 13, 10), 0.003f);
  // world from depth is the identity turn at (0, 1.25, -2): colour is 0.1 m to the right.
  EXPECT_THAT(capture->frames->capture_world_from_camera(FrameIdx{0})->translation_m.x(),
              testing::DoubleNear(0.1, 1e-6));
}

TEST(Sens, MotionsAndUnitsAreUnderstood) {
  const TempDir dir;
  WriteText(dir.path() / "a.sens", foreign::Sens({.depth_shift = 5000, .num_motions = 7}));
  const Result<dataset::Capture> capture = OpenCapture(dir.path() / "a.sens");
  ASSERT_TRUE(capture.ok());
  EXPECT_THAT(capture->warnings, Contains(HasSubstr("7 motion")));
  EXPECT_FLOAT_EQ(capture->frames->ReadDepth(FrameIdx{0})->depth_m(1, 0), 1003 / 5000.0f);
}

TEST(Sens, CutFileGivesTheFramesBeforeTheCut) {
  const TempDir dir;
  const std::string whole = foreign::Sens({.num_frames = 5});
  const fs::path file = dir.path() / "a.sens";
  std::size_t most = 0;
  for (std::size_t size = 0; size < whole.size(); size += 97) {
    WriteText(file, whole.substr(0, size));
    const Result<dataset::Capture> capture = OpenCapture(file);
    if (!capture.ok()) {
      EXPECT_EQ(capture.error().code, ErrorCode::kInvalidInput);
      EXPECT_THAT(capture.error().message, HasSubstr("a.sens"));
      continue;
    }
    const auto count = static_cast<std::size_t>(capture->frames->num_frames());
    EXPECT_GE(count, most);
    most = count;
    if (count < 5) {
      EXPECT_THAT(capture->warnings, Contains(HasSubstr("says it holds 5 frames")));
    }
    for (int i = 0; i < capture->frames->num_frames(); ++i)
      EXPECT_TRUE(capture->frames->Read(FrameIdx{i}).ok()) << "cut at " << size;
  }
  EXPECT_GE(most, 4u);
}

// A .sens whose header says what it likes.
struct Lie {
  std::string name;
  std::function<std::string()> bytes;
  std::string message;
};
void PrintTo(const Lie& lie, std::ostream* out) { *out << lie.name; }

std::string HeaderWith(std::uint64_t num_frames,
                       std::uint32_t width = 32,
                       std::uint32_t height = 24,
                       float depth_shift = 1000) {
  SensBytes out{foreign::SensHeader({})};
  const std::size_t sizes_at = out.bytes.size() - 4 - 16;
  for (const std::size_t at : {sizes_at, sizes_at + 8}) {
    std::memcpy(out.bytes.data() + at, &width, 4);
    std::memcpy(out.bytes.data() + at + 4, &height, 4);
  }
  std::memcpy(out.bytes.data() + out.bytes.size() - 4, &depth_shift, 4);
  out.Put(num_frames);
  return out.bytes;
}

std::string OneFrame(std::uint64_t colour_bytes,
                     std::uint64_t depth_bytes,
                     const std::string& data) {
  SensBytes out;
  out.PutMatrix(foreign::kIdentity).Put(std::uint64_t{1}).Put(std::uint64_t{1});
  out.Put(colour_bytes).Put(depth_bytes);
  return out.bytes + data;
}

class SensLies : public testing::TestWithParam<Lie> {};

TEST_P(SensLies, AreRefusedWithoutTheirMemory) {
  const TempDir dir;
  const fs::path file = dir.path() / "a.sens";
  const std::string bytes = GetParam().bytes();
  WriteText(file, bytes);
  testing_support::ForgetAllocations();
  const std::string message = Refusal(file);
  EXPECT_THAT(message, AllOf(HasSubstr("a.sens"), HasSubstr(GetParam().message)));
  // Hashing reads a mebibyte at a time; a table of raw values has 256 KiB.
  EXPECT_LE(testing_support::LargestAllocation(), (std::size_t{1} << 20) + 1024 * bytes.size());
}

constexpr std::uint64_t kHuge = std::uint64_t{1} << 62;

INSTANTIATE_TEST_SUITE_P(
    All,
    SensLies,
    testing::Values(
        Lie{"Empty", [] { return std::string(); }, "header"},
        Lie{"OldVersion",
            [] { return SensBytes().Put(2u).Put(std::uint64_t{0}).bytes; },
            "version"},
        Lie{"NameLength", [] { return SensBytes().Put(4u).Put(kHuge).bytes; }, "name"},
        Lie{"NumFrames", [] { return HeaderWith(kHuge); }, "number of frames"},
        Lie{"NumFramesTwice",
            [] { return HeaderWith(1000) + OneFrame(0, 0, std::string(200, 'x')); },
            "number of frames"},
        Lie{"NoFrames", [] { return HeaderWith(0); }, "no frames"},
        Lie{"ColourBytes",
            [] { return HeaderWith(1) + OneFrame(kHuge, 10, std::string(400, 'x')); },
            "first frame"},
        Lie{"DepthBytes",
            [] { return HeaderWith(1) + OneFrame(10, ~std::uint64_t{0}, std::string(400, 'x')); },
            "first frame"},
        Lie{"SumOverflows",
            [] {
              return HeaderWith(1) + OneFrame(~std::uint64_t{0} - 50, 100, std::string(400, 'x'));
            },
            "first frame"},
        Lie{"Width",
            [] { return HeaderWith(1, 0xFFFFFFFFu) + OneFrame(5, 5, std::string(10, 'x')); },
            "colour width"},
        Lie{"LargeImages",
            [] {
              return HeaderWith(1, 16000, 16000) +
                     OneFrame(foreign::ColourFile(0).size(),
                              foreign::ZlibDepth(0).size(),
                              foreign::ColourFile(0) + foreign::ZlibDepth(0));
            },
            "fx"},
        Lie{"LargeImagesOfAPlausibleCamera",
            [] {
              std::string header = HeaderWith(1, 16000, 16000);
              // Behind version, length and name of the sensor; depth's matrices come 128 bytes
              // later.
              for (const std::size_t matrix : {std::size_t{27}, std::size_t{27 + 128}}) {
                for (const auto& [cell, value] :
                     {std::pair(0, 12000.0f), {5, 12000.0f}, {2, 8000.0f}, {6, 8000.0f}}) {
                  std::memcpy(
                      header.data() + matrix + 4 * static_cast<std::size_t>(cell), &value, 4);
                }
              }
              return header + OneFrame(foreign::ColourFile(0).size(),
                                       foreign::ZlibDepth(0).size(),
                                       foreign::ColourFile(0) + foreign::ZlibDepth(0));
            },
            "none of 1 frames"},
        Lie{"DepthShift",
            [] { return HeaderWith(1, 32, 24, 0.0f) + OneFrame(5, 5, std::string(10, 'x')); },
            "depth shift"},
        Lie{"DepthShiftNan",
            [] {
              return HeaderWith(1, 32, 24, std::nanf("")) + OneFrame(5, 5, std::string(10, 'x'));
            },
            "depth shift"},
        Lie{"Text", [] { return std::string(5000, 'A'); }, "version"}),
    [](const auto& test) { return test.param.name; });

TEST(Sens, DamagedBytesNeverEndTheProgram) {
  const TempDir dir;
  const fs::path file = dir.path() / "a.sens";
  Random random(11);
  for (const int codec : {0, 1, 2}) {
    const std::string whole = foreign::Sens({.colour_codec = codec, .depth_codec = codec});
    for (int trial = 0; trial < 60; ++trial) {
      std::string bytes = whole;
      for (int k = 0; k < 4; ++k) {
        bytes[random.Index(bytes.size())] = static_cast<char>(random.Index(256));
      }
      WriteText(file, bytes);
      const Result<dataset::Capture> capture = OpenCapture(file);
      if (!capture.ok()) continue;
      for (int i = 0; i < capture->frames->num_frames(); ++i) {
        const Result<Frame> frame = capture->frames->Read(FrameIdx{i});
        if (!frame.ok()) {
          EXPECT_THAT(frame.error().message, HasSubstr("a.sens"));
        }
      }
    }
  }
}

TEST(UnpackDepth, RefusesSizesThatTheBytesCannotHold) {
  testing_support::ForgetAllocations();
  for (const formats::SensDepthCodec codec : {formats::SensDepthCodec::kRaw,
                                              formats::SensDepthCodec::kZlib,
                                              formats::SensDepthCodec::kOcci}) {
    const Result<RawDepthImage> depth = formats::UnpackDepth(codec, "a few bytes", 16384, 16384);
    ASSERT_FALSE(depth.ok());
    EXPECT_THAT(depth.error().message, HasSubstr("16384"));
  }
  EXPECT_LT(testing_support::LargestAllocation(), 100000u);
  // A stream that ends early, and one that says more than the image has.
  EXPECT_FALSE(
      formats::UnpackDepth(formats::SensDepthCodec::kOcci, std::string(30, '\0'), 32, 24).ok());
  EXPECT_FALSE(
      formats::UnpackDepth(formats::SensDepthCodec::kOcci, std::string(200, '\x5F'), 32, 24).ok());
  EXPECT_FALSE(
      formats::UnpackDepth(formats::SensDepthCodec::kZlib, foreign::ZlibDepth(0), 32, 23).ok());
}

TEST(Sens, SeveralInAFolderAreAQuestion) {
  const TempDir dir;
  WriteText(dir.path() / "a.sens", foreign::Sens({}));
  WriteText(dir.path() / "b.sens", foreign::Sens({}));
  EXPECT_THAT(Refusal(dir.path()),
              AllOf(HasSubstr("nearest is scannet"), HasSubstr("there are 2")));
}

}  // namespace
}  // namespace deepslam::layouts
