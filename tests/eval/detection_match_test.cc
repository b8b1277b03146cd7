#include "deepslam/eval/detection_match.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace deepslam::eval {
namespace {

TEST(VisibleBoxes, AreRoundThePixelsOfEachNumber) {
  Image<std::uint16_t> masks(20, 10, 0);
  for (int v = 2; v < 5; ++v) {
    for (int u = 3; u < 9; ++u) masks(u, v) = 2;
  }
  masks(19, 9) = 3;
  masks(0, 0) = 9;  // no object of the list
  const std::vector<Box2> boxes = VisibleBoxes(masks, 3, 2);
  ASSERT_EQ(boxes.size(), 3U);
  EXPECT_TRUE(boxes[0].empty()) << "not there";
  EXPECT_EQ(boxes[1], (Box2{2.5, 1.5, 8.5, 4.5}));
  EXPECT_EQ(boxes[1].area_px(), 18) << "as many as there are pixels";
  EXPECT_TRUE(boxes[2].empty()) << "too few pixels";
}

TEST(MatchBoxes, TakesEachBoxOnceAndItsClassFirst) {
  const std::vector<ImageBox> truth = {{"chair", {0, 0, 10, 10}}, {"table", {20, 0, 40, 10}}};
  EXPECT_THAT(MatchBoxes({}, truth, 0.5), testing::IsEmpty());
  EXPECT_THAT(MatchBoxes(truth, {}, 0.5), testing::IsEmpty());
  // The better overlap bears the wrong name; the second chair box is one too many.
  const std::vector<ImageBox> detected = {{"sofa", {0, 0, 10, 10}},
                                          {"chair", {0, 0, 8, 10}},
                                          {"chair", {0, 0, 9, 10}},
                                          {"bed", {20, 0, 38, 10}},
                                          {"table", {20, 0, 29, 10}}};
  const std::vector<BoxMatch> matches = MatchBoxes(detected, truth, 0.5);
  ASSERT_EQ(matches.size(), 2U);
  EXPECT_EQ(matches[0].truth, 0U);
  EXPECT_EQ(matches[0].detected, 2U);
  EXPECT_TRUE(matches[0].same_class);
  EXPECT_EQ(matches[1].detected, 3U) << "the table's own box covers less than half of it";
  EXPECT_FALSE(matches[1].same_class);
}

}  // namespace
}  // namespace deepslam::eval
