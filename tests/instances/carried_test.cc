#include "deepslam/instances/carried.h"

#include <string>
#include <vector>

#include <gmock/gmock.h>

namespace deepslam::instances {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

Instance Block(const Eigen::Vector2d& centre_m,
               const Eigen::Vector2d& size_m,
               double bottom_m,
               double top_m) {
  Instance instance;
  instance.class_name = "furniture";
  instance.box_level = {centre_m, 0, size_m.x(), size_m.y(), bottom_m, top_m};
  return instance;
}

Instance Counter() { return Block({0, 0}, {1.8, 0.6}, 0, 0.9); }

// Why a thing beside a counter is rejected.
std::string Reason(const Instance& thing, const Instance& counter = Counter()) {
  std::vector<Instance> instances = {thing, counter};
  RejectCarried(instances);
  EXPECT_EQ(instances[1].rejection, counter.rejection);
  return instances[0].rejection;
}

TEST(RejectCarried, WhatNothingNamesAndStandsOnAThing) {
  const Instance box = Block({0.4, 0.1}, {0.5, 0.3}, 0.93, 1.2);
  EXPECT_THAT(Reason(box), HasSubstr("stands on a furniture"));
  Instance oven = box;
  oven.is_named = true;
  EXPECT_THAT(Reason(oven), IsEmpty());
}

TEST(RejectCarried, NeitherWhatHangsAboveNorWhatStandsBesideOrOnTheFloor) {
  EXPECT_THAT(Reason(Block({0.4, 0.1}, {0.8, 0.35}, 1.4, 2.1)), IsEmpty());
  EXPECT_THAT(Reason(Block({1.5, 0}, {0.5, 0.5}, 0.4, 1.2)), IsEmpty());
  EXPECT_THAT(Reason(Block({0.4, 0.2}, {0.5, 0.5}, 0, 0.9)), IsEmpty());
}

TEST(RejectCarried, NothingStandsOnWhatIsNoThingOrSmaller) {
  const Instance box = Block({0.4, 0.1}, {0.5, 0.3}, 0.93, 1.2);
  Instance rim = Counter();
  rim.rejection = "small";
  rim.box_level.top_m = 0.5;
  Instance low = box;
  low.box_level.bottom_m = 0.52;
  EXPECT_THAT(Reason(low, rim), IsEmpty());
  EXPECT_THAT(Reason(Block({0, 0}, {1.6, 0.5}, 0.4, 1.9), Block({0, 0}, {1.6, 0.5}, 0, 0.4)),
              IsEmpty());
}

TEST(RejectCarried, WhatBeginsAtTheHeightOfTopsThoughNothingIsSeenUnderIt) {
  EXPECT_THAT(Reason(Block({3, 0}, {0.6, 0.3}, 0.9, 1.2)), HasSubstr("stands on something"));
  // The top of a counter whose front nobody saw.
  EXPECT_THAT(Reason(Block({3, 0}, {1.5, 0.6}, 0.85, 0.95)), IsEmpty());
}

TEST(RejectCarried, TakesNoInstances) {
  std::vector<Instance> none;
  RejectCarried(none);
  EXPECT_THAT(none, IsEmpty());
}

}  // namespace
}  // namespace deepslam::instances
