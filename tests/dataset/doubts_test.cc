#include "deepslam/dataset/doubts.h"

#include <gmock/gmock.h>

namespace deepslam::dataset {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

PinholeCamera Scaled(double factor) {
  return {640, 480, 525 * factor, 525 * factor, 319.5 * factor, 239.5 * factor};
}

TEST(CameraDoubts, NoneOfCamerasForRooms) {
  EXPECT_THAT(CameraDoubts(Scaled(1)), IsEmpty());
  EXPECT_THAT(CameraDoubts({640, 480, 526.98, 526.98, 327.75, 242.58}), IsEmpty());
  EXPECT_THAT(CameraDoubts({256, 192, 212, 212, 127.5, 95.5}), IsEmpty()) << "phone";
  EXPECT_THAT(CameraDoubts({1024, 1024, 504, 504, 511, 513}), IsEmpty()) << "wide view of a Kinect";
  EXPECT_THAT(CameraDoubts({192, 256, 212, 212, 95.5, 127.5}), IsEmpty()) << "on its side";
}

TEST(CameraDoubts, IntrinsicsOfAnotherImageSize) {
  EXPECT_THAT(CameraDoubts(Scaled(0.5)),
              ElementsAre(AllOf(HasSubstr("(159.8, 119.8)"), HasSubstr("capture.yaml"))));
  EXPECT_THAT(CameraDoubts({640, 480, 2100, 2100, 319.5, 239.5}),
              ElementsAre(AllOf(HasSubstr("17 deg wide"), HasSubstr("fx 2100.0"))));
}

std::vector<double> Times(double interval_s, int count = 20) {
  std::vector<double> times_s;
  for (int k = 0; k < count; ++k) times_s.push_back(1.6e9 + k * interval_s);
  return times_s;
}

TEST(TimeDoubts, NoneOfRecordings) {
  for (const double interval_s : {0.001, 1 / 30.0, 0.2, 2.0})
    EXPECT_THAT(TimeDoubts(Times(interval_s)), IsEmpty()) << interval_s;
  EXPECT_THAT(TimeDoubts({}), IsEmpty());
  EXPECT_THAT(TimeDoubts(Times(100, 2)), IsEmpty()) << "one interval says nothing";
  std::vector<double> paused = Times(1 / 30.0);
  for (std::size_t k = 12; k < paused.size(); ++k) paused[k] += 300;
  EXPECT_THAT(TimeDoubts(paused), IsEmpty()) << "a pause";
}

TEST(TimeDoubts, OtherUnitsThanSeconds) {
  EXPECT_THAT(TimeDoubts(Times(33.3)), ElementsAre(HasSubstr("milliseconds")));
  EXPECT_THAT(TimeDoubts(Times(33333)), ElementsAre(HasSubstr("microseconds")));
  EXPECT_THAT(TimeDoubts(Times(3.3333e7)), ElementsAre(HasSubstr("nanoseconds")));
  EXPECT_THAT(TimeDoubts(Times(33e-6)), ElementsAre(HasSubstr("in seconds")));
}

IntensityImage Grey(int base, int range) {
  IntensityImage picture(64, 48);
  for (std::size_t k = 0; k < picture.size(); ++k)
    picture.data()[k] = static_cast<float>(base + static_cast<int>(k) % (range + 1));
  return picture;
}

TEST(ColourDoubts, PicturesOfOneTone) {
  const auto doubts = [](std::vector<IntensityImage> pictures) { return ColourDoubts(pictures); };
  EXPECT_THAT(doubts({Grey(0, 0), Grey(0, 0), Grey(250, 4)}), ElementsAre(HasSubstr("3 of 3")));
  EXPECT_THAT(doubts({Grey(0, 0), Grey(0, 0), Grey(40, 90)}), ElementsAre(HasSubstr("2 of 3")));
  EXPECT_THAT(doubts({Grey(0, 0), Grey(20, 30)}), IsEmpty()) << "a lens that was covered at first";
  EXPECT_THAT(doubts({Grey(230, 20)}), IsEmpty()) << "a white wall";
  EXPECT_THAT(doubts({}), IsEmpty());
}

DepthImage Room(float times) {
  DepthImage depth_m(64, 48);
  for (std::size_t k = 0; k < depth_m.size(); ++k)
    depth_m.data()[k] = k % 5 == 0 ? 0.0F : times * (1 + 0.001F * static_cast<float>(k));
  return depth_m;
}

TEST(DepthDoubts, UnitsOfAnotherCamera) {
  const auto doubts = [](float times) {
    const std::vector<DepthImage> depths_m = {Room(times), DepthImage(), DepthImage(4, 4)};
    return DepthDoubts(depths_m);
  };
  EXPECT_THAT(doubts(1), IsEmpty());
  EXPECT_THAT(doubts(0.3F), IsEmpty()) << "near things";
  EXPECT_THAT(doubts(1.8F), IsEmpty()) << "a hall";
  EXPECT_THAT(doubts(0.18F),
              ElementsAre(AllOf(HasSubstr("nearer than"), HasSubstr("depth_units_per_m"))));
  EXPECT_THAT(doubts(5), ElementsAre(HasSubstr("farther than")));
  EXPECT_THAT(DepthDoubts({}), IsEmpty());
  EXPECT_THAT(DepthDoubts(std::vector<DepthImage>{DepthImage(8, 8)}), IsEmpty())
      << "no depth at all";
}

}  // namespace
}  // namespace deepslam::dataset
