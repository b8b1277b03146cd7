#include "deepslam/report/sanity_checks.h"

#include <cstddef>
#include <set>
#include <string>
#include <vector>

#include <gmock/gmock.h>

namespace deepslam::report {
namespace {

using testing::HasSubstr;

OptimizedMap MapWithFrames(int num_tracked, int num_lost) {
  OptimizedMap map;
  for (int i = 0; i < num_tracked + num_lost; ++i) {
    map.frames.push_back({FrameIdx{i},
                          i / 30.0,
                          {},
                          i < num_tracked ? TrackingStatus::kTracked : TrackingStatus::kLost,
                          FrameIdx{0},
                          0,
                          1});
  }
  map.keyframes = {FrameIdx{0}, FrameIdx{10}, FrameIdx{20}};
  map.has_ground = true;
  map.summary.converged = true;
  MapObject object;
  object.id = ObjectId{0};
  object.class_name = "chair";
  object.confidence = 0.9;
  map.map.objects = {object};
  return map;
}

// A walk at one pace; from `jump_at` on, the camera stands `jump_m` further along.
OptimizedMap MapOfAWalk(std::size_t jump_at, double jump_m) {
  OptimizedMap map = MapWithFrames(100, 0);
  for (std::size_t k = 0; k < map.frames.size(); ++k)
    map.frames[k].world_from_camera.translation_m.x() =
        0.02 * static_cast<double>(k) + (k >= jump_at ? jump_m : 0);
  return map;
}

TEST(CheckRun, NamesTheFrameAtWhichTheCameraJumps) {
  EXPECT_EQ(CheckRun(MapOfAWalk(40, 0), {}).verdict, Verdict::kGood);
  EXPECT_EQ(CheckRun(MapOfAWalk(40, 0.1), {}).verdict, Verdict::kGood);
  const RunVerdict jumped = CheckRun(MapOfAWalk(40, 0.5), {});
  EXPECT_EQ(jumped.verdict, Verdict::kDoubtful);
  EXPECT_THAT(jumped.reasons, testing::ElementsAre(HasSubstr("0.52 m at frame 40,")));
  // Keyframes far apart, as sparse captures have them, are a pace of their own.
  OptimizedMap sparse = MapOfAWalk(40, 0);
  for (TrackedFrame& frame : sparse.frames) frame.world_from_camera.translation_m *= 20;
  EXPECT_EQ(CheckRun(sparse, {}).verdict, Verdict::kGood);
}

// Keyframes every ten frames; tracking starts anew at each of `starts`, as its lost keyframes.
struct BrokenWalk {
  OptimizedMap map = MapOfAWalk(0, 0);
  std::vector<KeyframeJoin> joins;

  explicit BrokenWalk(const std::set<int>& starts) {
    map.keyframes.clear();
    for (int k = 0; k < 100; k += 10) {
      map.keyframes.push_back(FrameIdx{k});
      if (k == 0) continue;
      joins.push_back(Join(k - 10, k));
      joins.back().composed = starts.contains(k);
      if (starts.contains(k))
        map.frames[static_cast<std::size_t>(k)].status = TrackingStatus::kLost;
    }
  }

  static KeyframeJoin Join(int i, int j) { return {FrameIdx{i}, FrameIdx{j}}; }
};

TEST(CheckRun, NamesSubTrajectoriesWhosePlaceNobodyMeasured) {
  BrokenWalk walk({60});
  EXPECT_EQ(CheckRun(BrokenWalk({}).map, walk.joins).verdict, Verdict::kGood)
      << "a chain of tracked frames is measured";
  const RunVerdict two = CheckRun(walk.map, walk.joins);
  EXPECT_EQ(two.verdict, Verdict::kBad);
  EXPECT_THAT(two.reasons,
              testing::ElementsAre(testing::AllOf(HasSubstr("at frame 60"),
                                                  HasSubstr("frames 60 to 99"),
                                                  HasSubstr("not measured"),
                                                  HasSubstr("40 %"),
                                                  HasSubstr("overlap"))));
  // A loop, or keyframes re-registered across the loss.
  walk.joins.push_back(BrokenWalk::Join(20, 80));
  EXPECT_EQ(CheckRun(walk.map, walk.joins).verdict, Verdict::kGood);
}

TEST(CheckRun, NamesTheSmallerSubTrajectoryWhereverItStands) {
  const BrokenWalk first({10});
  const RunVerdict early = CheckRun(first.map, first.joins);
  EXPECT_EQ(early.verdict, Verdict::kDoubtful);
  EXPECT_THAT(
      early.reasons,
      testing::ElementsAre(testing::AllOf(HasSubstr("at frame 10"), HasSubstr("frames 0 to 9 "))));
  // The last part has met the first again, so that what lies between alone hangs in the air.
  BrokenWalk between({30, 40});
  EXPECT_THAT(CheckRun(between.map, between.joins).reasons,
              testing::ElementsAre(HasSubstr("1 more such part")));
  between.joins.push_back(BrokenWalk::Join(10, 70));
  const RunVerdict middle = CheckRun(between.map, between.joins);
  EXPECT_EQ(middle.verdict, Verdict::kDoubtful);
  EXPECT_THAT(middle.reasons,
              testing::ElementsAre(testing::AllOf(
                  HasSubstr("at frame 30"), HasSubstr("frames 30 to 39 "), HasSubstr("10 %"))));
}

TEST(CheckRun, AFrameThatIsFoundAgainDoesNotVouchForWhatIsBetween) {
  // Tracking starts anew at 30 and meets keyframe 20 again at 40: tracked, with a measured edge to
  // 20 and a composed one to its neighbour.
  BrokenWalk found({30, 40});
  found.map.frames[40].status = TrackingStatus::kTracked;
  found.joins.push_back(BrokenWalk::Join(20, 40));
  EXPECT_THAT(CheckRun(found.map, found.joins).reasons,
              testing::ElementsAre(HasSubstr("frames 30 to 39 ")));
}

TEST(CheckRun, SeesJumpsWhereTheClockWasSetBack) {
  const auto set_back = [](OptimizedMap map) {
    for (std::size_t k = 40; k < map.frames.size(); ++k) map.frames[k].time_s -= 0.7;
    return map;
  };
  EXPECT_EQ(CheckRun(set_back(MapOfAWalk(40, 0)), {}).verdict, Verdict::kGood);
  EXPECT_THAT(CheckRun(set_back(MapOfAWalk(40, 0.5)), {}).reasons,
              testing::ElementsAre(HasSubstr("0.52 m at frame 40,")));
}

TEST(CheckRun, FollowsWhatWentWrong) {
  EXPECT_EQ(CheckRun(MapWithFrames(100, 0), {}).verdict, Verdict::kGood);
  EXPECT_EQ(CheckRun(MapWithFrames(90, 10), {}).verdict, Verdict::kDoubtful);
  EXPECT_EQ(CheckRun(MapWithFrames(40, 60), {}).verdict, Verdict::kBad);
  OptimizedMap standing = MapWithFrames(100, 0);
  standing.keyframes = {FrameIdx{0}};
  EXPECT_EQ(CheckRun(standing, {}).verdict, Verdict::kDoubtful);
  OptimizedMap map = MapWithFrames(100, 0);
  map.has_ground = false;
  map.map.objects[0].confidence = 0.1;
  const RunVerdict doubtful = CheckRun(map, {});
  EXPECT_EQ(doubtful.verdict, Verdict::kDoubtful);
  EXPECT_THAT(doubtful.reasons, testing::ElementsAre(HasSubstr("ground"), HasSubstr("chair_00")));
  map.map.objects.clear();
  EXPECT_EQ(CheckRun(map, {}).verdict, Verdict::kBad);
}

TEST(CheckRun, BeginsWithWhatIsDoubtedOfTheCapture) {
  const std::vector<std::string> doubts = {"half of the depth is nearer than 0.20 m"};
  const RunVerdict doubted = CheckRun(MapWithFrames(100, 0), {}, doubts);
  EXPECT_EQ(doubted.verdict, Verdict::kDoubtful);
  EXPECT_THAT(doubted.reasons, testing::ElementsAreArray(doubts));
  const RunVerdict lost = CheckRun(MapWithFrames(40, 60), {}, doubts);
  EXPECT_EQ(lost.verdict, Verdict::kBad);
  EXPECT_THAT(lost.reasons, testing::ElementsAre(doubts[0], HasSubstr("could not be tracked")));
}

}  // namespace
}  // namespace deepslam::report
