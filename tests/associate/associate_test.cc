#include "deepslam/associate/associate.h"

#include <map>
#include <set>

#include <gmock/gmock.h>

#include "deepslam/scene/measured_parts.h"
#include "support/box_world.h"

namespace deepslam::associate {
namespace {

using testing::HasSubstr;
using testing::SizeIs;
using namespace testing_support;  // NOLINT

constexpr double kMargin_px = 6;

// Segments with true masks of all objects in all frames.
std::vector<Segment> TrueSegments(const BoxWorldSource& source, int num_objects) {
  std::vector<Segment> segments;
  int id = 0;
  for (int f = 0; f < source.num_frames(); ++f) {
    const BoxView view = source.View({f});
    for (int object = 0; object < num_objects; ++object) {
      const auto detection = DetectTruth(view, object, "chair");
      if (!detection) continue;
      Segment segment;
      segment.detection = {id++};
      segment.frame = {f};
      segment.class_name = "chair";
      segment.score = 0.8;
      segment.box_px = detection->box_px;
      Mask mask(320, 240);
      for (std::size_t p = 0; p < mask.size(); ++p) {
        if (view.object.data()[p] != object) continue;
        mask.data()[p] = 1;
        ++segment.num_points;
      }
      segment.mask = mask;
      const Box2& box = segment.box_px;
      segment.touches_border = box.u_min < kMargin_px || box.v_min < kMargin_px ||
                               box.u_max > 319 - kMargin_px || box.v_max > 239 - kMargin_px;
      segment.usable = segment.num_points >= 50;
      segment.reason = segment.usable ? "" : "too few points";
      segments.push_back(std::move(segment));
    }
  }
  return segments;
}

// Which object of the truth a detection shows, by its order of making.
std::map<DetectionId, int> TruthOf(const BoxWorldSource& source, int num_objects) {
  std::map<DetectionId, int> truth;
  int id = 0;
  for (int f = 0; f < source.num_frames(); ++f) {
    const BoxView view = source.View({f});
    for (int object = 0; object < num_objects; ++object) {
      if (DetectTruth(view, object, "chair")) truth[{id++}] = object;
    }
  }
  return truth;
}

std::vector<Cuboid> ChairsRoundTable() {
  std::vector<Cuboid> world;
  Append(world, ChairAt(0, -0.3, -0.8, -1));
  Append(world, ChairAt(1, 0.3, -0.8, -1));
  Append(world, ChairAt(2, 0, 0.8, 1));
  return world;
}

BoxWorldSource Round(int count, double step_deg) {
  return {ChairsRoundTable(), Orbit({0, 0, 0.4}, 2.8, 1.5, -120, step_deg, count)};
}

std::vector<int> PartsOf(const Odometry& odometry) {
  return PartsOfFrames(odometry, JoinsOf(odometry));
}

Association AssociateAll(const FrameSource& source,
                         const Odometry& odometry,
                         const std::vector<Segment>& segments,
                         const AssociateOptions& options = {}) {
  SilentProgress progress;
  Result<Association> result =
      Associate(source, odometry, PartsOf(odometry), segments, options, progress);
  EXPECT_TRUE(result.ok());
  return *std::move(result);
}

void ExpectEachDetectionOnce(const Association& association, const std::vector<Segment>& segments) {
  std::multiset<DetectionId> seen;
  for (const ObjectTrack& track : association.tracks) {
    std::set<FrameIdx> frames;
    for (const TrackMember& member : track.members) {
      seen.insert(member.detection);
      EXPECT_TRUE(frames.insert(member.frame).second) << "two detections of one object in a frame";
    }
  }
  for (const Rejection& rejection : association.rejections) {
    seen.insert(rejection.detection);
    EXPECT_FALSE(rejection.reason.empty());
  }
  EXPECT_EQ(seen.size(), segments.size());
  for (const Segment& segment : segments) EXPECT_EQ(seen.count(segment.detection), 1U);
}

TEST(Associate, FindsEachChairOnceAllRoundTheRoom) {
  const BoxWorldSource source = Round(24, 15);
  const auto segments = TrueSegments(source, 3);
  const auto truth = TruthOf(source, 3);
  const Association association = AssociateAll(source, source.TrueOdometry(), segments);
  EXPECT_THAT(association.tracks, SizeIs(3));
  for (const ObjectTrack& track : association.tracks) {
    std::set<int> objects;
    for (const TrackMember& member : track.members) objects.insert(truth.at(member.detection));
    EXPECT_THAT(objects, SizeIs(1)) << "track " << track.id << " mixes objects";
    EXPECT_GE(track.members.size(), 20U);
    EXPECT_FALSE(track.reason.empty());
  }
  ExpectEachDetectionOnce(association, segments);
}

TEST(Associate, DoesNotDependOnTheOrderWithinAFrame) {
  const BoxWorldSource source = Round(8, 15);
  const auto segments = TrueSegments(source, 3);
  std::vector<Segment> reversed;
  for (auto i = segments.rbegin(); i != segments.rend(); ++i) reversed.push_back(*i);
  const auto groups = [](const Association& association) {
    std::set<std::set<DetectionId>> result;
    for (const ObjectTrack& track : association.tracks) {
      std::set<DetectionId> members;
      for (const TrackMember& m : track.members) members.insert(m.detection);
      result.insert(members);
    }
    return result;
  };
  EXPECT_EQ(groups(AssociateAll(source, source.TrueOdometry(), segments)),
            groups(AssociateAll(source, source.TrueOdometry(), reversed)));
}

TEST(Associate, FindsAnObjectAgainAfterManyFramesWithoutIt) {
  const BoxWorldSource source = Round(16, 4);
  auto segments = TrueSegments(source, 3);
  const auto truth = TruthOf(source, 3);
  std::erase_if(segments, [&](const Segment& s) {
    return truth.at(s.detection) == 0 && s.frame.value >= 4 && s.frame.value < 12;
  });
  const Association association = AssociateAll(source, source.TrueOdometry(), segments);
  EXPECT_THAT(association.tracks, SizeIs(3));
  bool refound = false;
  for (const ObjectTrack& track : association.tracks) {
    for (const TrackMember& m : track.members) refound = refound || m.how == "model";
  }
  EXPECT_TRUE(refound);
}

// Two captures in one: tracking lost itself at a frame and went on where it was.
TEST(Associate, HoldsNothingAgainstWhatStandsWhereNobodyMeasured) {
  const BoxWorldSource source = Round(16, 4);
  const auto segments = TrueSegments(source, 3);
  const FrameIdx before{7}, cut{8};
  Odometry odometry = source.TrueOdometry();
  odometry.frames[8].status = TrackingStatus::kLost;
  odometry.edges.push_back({before, cut, Pose3{}, Matrix6d::Identity(), true});
  const Association apart = AssociateAll(source, odometry, segments);
  ExpectEachDetectionOnce(apart, segments);
  ASSERT_THAT(apart.tracks, SizeIs(6));
  for (const ObjectTrack& track : apart.tracks) {
    EXPECT_EQ(track.id.value, &track - apart.tracks.data());
    for (const TrackMember& member : track.members)
      EXPECT_EQ(member.frame < cut, track.members.front().frame < cut);
  }
  // Tracking met an earlier keyframe again.
  odometry.edges.push_back({FrameIdx{2}, FrameIdx{10}, Pose3{}, Matrix6d::Identity(), false});
  EXPECT_THAT(AssociateAll(source, odometry, segments).tracks, SizeIs(3));
}

TEST(Associate, StartsNothingAtTheBorderButMatchesThere) {
  const BoxWorldSource source = Round(6, 4);
  auto segments = TrueSegments(source, 1);
  for (Segment& s : segments) s.touches_border = true;
  const Association none = AssociateAll(source, source.TrueOdometry(), segments);
  EXPECT_THAT(none.tracks, SizeIs(0));
  ExpectEachDetectionOnce(none, segments);
  segments[3].touches_border = false;
  const Association one = AssociateAll(source, source.TrueOdometry(), segments);
  ASSERT_THAT(one.tracks, SizeIs(1));
  EXPECT_THAT(one.tracks[0].members, SizeIs(segments.size()));
}

TEST(Associate, LetsThingsTooLargeForTheImageStartAtTheBorder) {
  const BoxWorldSource source = Round(6, 4);
  auto segments = TrueSegments(source, 1);
  for (Segment& s : segments) {
    s.touches_border = true;
    s.box_px = {0, 40, 300, 239};
  }
  const Association one = AssociateAll(source, source.TrueOdometry(), segments);
  ASSERT_THAT(one.tracks, SizeIs(1));
  EXPECT_THAT(one.tracks[0].reason, HasSubstr("too large"));
  AssociateOptions as_in_the_paper;
  as_in_the_paper.border_span = 1.5;
  EXPECT_THAT(AssociateAll(source, source.TrueOdometry(), segments, as_in_the_paper).tracks,
              SizeIs(0));
}

TEST(Associate, LetsThingsStartThatAreSeenAtTheBorderAgainAndAgain) {
  const BoxWorldSource source = Round(10, 4);
  auto segments = TrueSegments(source, 1);
  ASSERT_THAT(segments, SizeIs(10));
  for (Segment& s : segments) s.touches_border = true;
  const Association one = AssociateAll(source, source.TrueOdometry(), segments);
  ASSERT_THAT(one.tracks, SizeIs(1));
  EXPECT_THAT(one.tracks[0].members, SizeIs(10));
  EXPECT_THAT(one.tracks[0].reason, HasSubstr("never within the margin"));
  AssociateOptions as_in_the_paper;
  as_in_the_paper.border_members = 0;
  EXPECT_THAT(AssociateAll(source, source.TrueOdometry(), segments, as_in_the_paper).tracks,
              SizeIs(0));
}

TEST(Associate, SecondDetectionsOfOneThingAreRejectedOnceToTheLastFrame) {
  const BoxWorldSource source = Round(6, 4);
  auto segments = TrueSegments(source, 1);
  ASSERT_THAT(segments, SizeIs(6));
  for (int i = 0; i < 6; ++i) {
    segments.push_back(segments[static_cast<std::size_t>(i)]);
    segments.back().detection = {100 + i};
  }
  const Association association = AssociateAll(source, source.TrueOdometry(), segments);
  ASSERT_THAT(association.tracks, SizeIs(1));
  EXPECT_THAT(association.tracks[0].members, SizeIs(6));
  EXPECT_THAT(association.rejections, SizeIs(6));
  ExpectEachDetectionOnce(association, segments);
}

TEST(Associate, SettlesTheClassByScore) {
  const BoxWorldSource source = Round(8, 4);
  auto segments = TrueSegments(source, 1);
  for (std::size_t i = 0; i < segments.size(); ++i) {
    segments[i].class_name = i % 3 == 1 ? "sofa" : "chair";
  }
  const Association association = AssociateAll(source, source.TrueOdometry(), segments);
  ASSERT_THAT(association.tracks, SizeIs(1));
  EXPECT_EQ(association.tracks[0].class_name, "chair");
}

TEST(Associate, DropsRareDoubtfulDetectionsAndKeepsRareGoodOnes) {
  const BoxWorldSource source = Round(1, 4);
  auto segments = TrueSegments(source, 2);
  ASSERT_THAT(segments, SizeIs(2));
  segments[1].score = 0.35;
  const Association association = AssociateAll(source, source.TrueOdometry(), segments);
  ASSERT_THAT(association.tracks, SizeIs(1));
  EXPECT_EQ(association.tracks[0].members[0].detection, segments[0].detection);
  ASSERT_THAT(association.rejections, SizeIs(1));
  EXPECT_THAT(association.rejections[0].reason, HasSubstr("too seldom"));
}

TEST(Associate, RejectsWhatItCannotUseAndGoesOn) {
  BoxWorldSource source = Round(8, 4);
  auto segments = TrueSegments(source, 1);
  ASSERT_THAT(segments, SizeIs(8));
  source.broken = {1};
  segments[2].mask = Mask(3, 3, 1);
  segments[3].frame = {1000};
  segments[4].usable = false;
  segments[4].reason = "";
  segments[5].frame = {-7};
  segments[6].mask = Mask(320, 240);
  const Association association = AssociateAll(source, source.TrueOdometry(), segments);
  EXPECT_THAT(association.rejections, SizeIs(6));
  ExpectEachDetectionOnce(association, segments);
}

TEST(Associate, HasNothingToSayAboutNothing) {
  const BoxWorldSource source = Round(2, 4);
  const Association association = AssociateAll(source, source.TrueOdometry(), {});
  EXPECT_THAT(association.tracks, SizeIs(0));
  EXPECT_THAT(association.rejections, SizeIs(0));
}

class StoppingProgress final : public Progress {
 public:
  void Report(std::size_t, std::size_t) override {}
  void Warn(std::string_view) override {}
  [[nodiscard]] bool StopRequested() const override { return true; }
};

TEST(Associate, StopsOnRequest) {
  const BoxWorldSource source = Round(2, 4);
  StoppingProgress progress;
  const Odometry odometry = source.TrueOdometry();
  const auto result =
      Associate(source, odometry, PartsOf(odometry), TrueSegments(source, 1), {}, progress);
  ASSERT_FALSE(result.ok());
  EXPECT_EQ(result.error().code, ErrorCode::kInterrupted);
}

}  // namespace
}  // namespace deepslam::associate
