#include "deepslam/associate/associate.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <iterator>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "deepslam/associate/match_frame.h"
#include "deepslam/associate/object_hypothesis.h"
#include "deepslam/associate/orphan_points.h"
#include "deepslam/associate/review_objects.h"
#include "deepslam/core/order_statistics.h"
#include "deepslam/core/parallel_ahead.h"

namespace deepslam::associate {
namespace {

constexpr std::size_t kLooksAhead = 8;                // frames whose depth is held, 1 MB each
constexpr std::size_t kMaxOrphanPoints = 12'000'000;  // 150 MB: 15,000 detections in full

// Largest share of the image's sides that a segment's box spans.
double Span(const Segment& segment, const PinholeCamera& camera) {
  return std::max(segment.box_px.width_px() / camera.width,
                  segment.box_px.height_px() / camera.height);
}

// What a frame's segments measured: found ahead of the matching, which goes frame by frame.
struct FrameLook {
  Result<Frame> frame;  // its depth
  // Per segment: its points and their cloud, where it is usable and fits the depth image.
  struct Measured {
    bool fits = false;
    std::vector<Eigen::Vector3f> points_world;
    PointCloud cloud_world{{}};
  };
  std::vector<Measured> measured;
};

FrameLook LookAt(const FrameSource& frames,
                 FrameIdx frame,
                 const Pose3& world_from_camera,
                 std::span<Segment* const> segments) {
  FrameLook look{frames.ReadDepth(frame), {}};
  look.measured.resize(segments.size());
  if (!look.frame.ok()) return look;
  const DepthImage& depth_m = look.frame->depth_m;
  for (std::size_t n = 0; n < segments.size(); ++n) {
    const PixelMask mask = std::exchange(segments[n]->mask, {});  // nobody asks for it again
    FrameLook::Measured& measured = look.measured[n];
    measured.fits = mask.width() == depth_m.width() && mask.height() == depth_m.height();
    if (!segments[n]->usable || !measured.fits) continue;
    measured.points_world = MaskPoints(mask.Unpacked(),
                                       depth_m,
                                       frames.camera(),
                                       world_from_camera,
                                       AssociateOptions::kMaxSegmentPoints);
    measured.cloud_world = PointCloud(measured.points_world);
  }
  return look;
}

// What the matchers of all parts of a path share.
struct Shared {
  int num_started = 0;  // objects
  OrphanPoints orphan_points{kMaxOrphanPoints};
};

class Matcher {
 public:
  Matcher(const PinholeCamera& camera,
          const Trajectory& trajectory,
          const AssociateOptions& options,
          Shared& shared)
      : camera_(camera), trajectory_(trajectory), options_(options), shared_(shared) {}

  void AddFrame(FrameIdx frame, std::span<Segment* const> segments, FrameLook look);
  void Finish(Association& association);

 private:
  std::vector<int> MakeObservations(std::span<Segment* const> segments,
                                    std::vector<FrameLook::Measured> measured);
  void Take(const Match& match, const std::string& how);
  void Add(ObjectHypothesis& object, int observation, TrackMember member);
  void Retire(std::span<const int> voters);
  void StartObjects(std::span<const int> unmatched);
  void RecallOrphans();
  void AdoptOrphans();
  void StartObjectsAtBorder();
  ObjectHypothesis& Object(ObjectId id);
  void Reject(const Segment& segment, const std::string& reason) {
    rejections_.push_back({segment.detection, segment.frame, reason});
  }

  // Usable, but could start nothing.
  struct Orphan {
    int observation = 0;
    std::size_t points_key = 0;
  };

  const PinholeCamera& camera_;
  const Trajectory& trajectory_;
  const AssociateOptions& options_;
  Shared& shared_;
  std::vector<Observation> all_;
  std::vector<ObjectHypothesis> objects_;
  std::deque<std::vector<int>> voters_;
  std::vector<Orphan> waiting_;  // without their points, until all objects are known
  std::vector<int> orphans_;     // with their points, afterwards
  CoarseViews coarse_views_;
  std::vector<Rejection> rejections_;
};

ObjectHypothesis& Matcher::Object(ObjectId id) {
  const auto found = std::find_if(
      objects_.begin(), objects_.end(), [id](const ObjectHypothesis& o) { return o.id == id; });
  DEEPSLAM_CHECK(found != objects_.end(), "matched object does not exist");
  return *found;
}

void Matcher::Take(const Match& match, const std::string& how) {
  Add(Object(match.object),
      match.observation,
      {{}, {}, match.num_votes, match.dissimilarity_m, how});
}

void Matcher::Add(ObjectHypothesis& object, int observation, TrackMember member) {
  AddMember(object, all_, observation, std::move(member));
  object.points_world.Add(all_[static_cast<std::size_t>(observation)].points_world,
                          0.5 * AssociateOptions::kVoxel_m);
}

void Matcher::Retire(std::span<const int> voters) {
  for (const int i : voters) {
    Observation& observation = all_[static_cast<std::size_t>(i)];
    observation.cloud_world = PointCloud({});
    const std::vector<Eigen::Vector3f> points_world = std::exchange(observation.points_world, {});
    if (observation.object.valid()) continue;
    waiting_.push_back({i, shared_.orphan_points.Keep(points_world)});
  }
}

std::vector<int> Matcher::MakeObservations(std::span<Segment* const> segments,
                                           std::vector<FrameLook::Measured> measured) {
  std::vector<int> current;
  for (std::size_t n = 0; n < segments.size(); ++n) {
    const Segment& segment = *segments[n];
    if (!segment.usable || !measured[n].fits) {
      Reject(segment,
             !segment.usable ? (segment.reason.empty() ? "not usable" : segment.reason)
                             : "mask does not fit the depth image");
      continue;
    }
    if (measured[n].points_world.empty()) {
      Reject(segment, "no depth in the mask");
      continue;
    }
    Observation observation;
    observation.segment = &segment;
    observation.points_world = std::move(measured[n].points_world);
    observation.cloud_world = std::move(measured[n].cloud_world);
    current.push_back(static_cast<int>(all_.size()));
    all_.push_back(std::move(observation));
  }
  return current;
}

void Matcher::StartObjects(std::span<const int> unmatched) {
  for (const int i : unmatched) {
    const Segment& segment = *all_[static_cast<std::size_t>(i)].segment;
    if (segment.touches_border) continue;
    ObjectHypothesis object;
    object.id = {shared_.num_started++};
    object.reason = "no object known before agrees with detection " +
                    std::to_string(segment.detection.value) + " of frame " +
                    std::to_string(segment.frame.value);
    objects_.push_back(std::move(object));
    Take({i, objects_.back().id, 0, 0.0}, "new");
  }
}

void Matcher::AddFrame(FrameIdx frame, std::span<Segment* const> segments, FrameLook look) {
  if (!look.frame.ok()) {
    for (const Segment* segment : segments) Reject(*segment, "frame cannot be read");
    return;
  }
  const Pose3 camera_from_world = trajectory_.at(frame).world_from_camera.Inverse();
  coarse_views_.Add(frame, camera_from_world, look.frame->depth_m);
  const std::vector<int> current = MakeObservations(segments, std::move(look.measured));
  if (current.empty()) return;
  const std::vector<std::vector<int>> voters(voters_.begin(), voters_.end());
  const auto take_all = [&](const std::vector<Match>& matches, const std::string& how) {
    for (const Match& match : matches) Take(match, how);
  };
  const auto unmatched = [&] {
    std::vector<int> rest;
    for (const int i : current) {
      if (!all_[static_cast<std::size_t>(i)].object.valid()) rest.push_back(i);
    }
    return rest;
  };
  take_all(MatchByVotes(current, voters, all_, camera_, camera_from_world), "vote");
  take_all(MatchByModels(unmatched(), objects_, all_), "model");
  StartObjects(unmatched());
  voters_.push_back(current);
  if (static_cast<int>(voters_.size()) > AssociateOptions::kNumVoteFrames) {
    Retire(voters_.front());
    voters_.pop_front();
  }
}

void Matcher::RecallOrphans() {
  for (const std::vector<int>& voters : voters_) Retire(voters);
  voters_.clear();
  for (const Orphan& orphan : waiting_) {
    all_[static_cast<std::size_t>(orphan.observation)].points_world =
        shared_.orphan_points.Take(orphan.points_key);
    orphans_.push_back(orphan.observation);
  }
  waiting_.clear();
}

// Detections that could start nothing, held against what was found afterwards.
void Matcher::AdoptOrphans() {
  std::vector<int> left;
  for (const int i : orphans_) {
    const std::vector<int> one = {i};
    const std::vector<Match> matches = MatchByModels(one, objects_, all_);
    if (matches.empty()) {
      left.push_back(i);
    } else {
      Take(matches.front(), "model");
    }
  }
  orphans_ = std::move(left);
}

// Orphans that agree with each other: large things that never fit into the image with a margin, and
// things at the rim of all that was seen.
void Matcher::StartObjectsAtBorder() {
  std::vector<ObjectHypothesis> groups;
  for (const int i : orphans_) {
    const std::vector<int> one = {i};
    const std::vector<Match> matches = MatchByModels(one, groups, all_);
    TrackMember member;
    member.how = "model";
    auto group = groups.end();
    if (!matches.empty()) {
      member.dissimilarity_m = matches.front().dissimilarity_m;
      group = std::find_if(groups.begin(), groups.end(), [&](const ObjectHypothesis& o) {
        return o.id == matches.front().object;
      });
    } else {
      member.how = "new";
      ObjectHypothesis started;
      started.id = {shared_.num_started++};
      groups.push_back(std::move(started));
      group = groups.end() - 1;
    }
    Add(*group, i, std::move(member));
  }
  for (ObjectHypothesis& group : groups) {
    std::vector<double> spans;
    for (const int i : group.observations) {
      spans.push_back(Span(*all_[static_cast<std::size_t>(i)].segment, camera_));
    }
    const double span = Median(spans);
    const bool seen_well = static_cast<int>(spans.size()) >= options_.min_members ||
                           group.MeanScore(all_) >= AssociateOptions::kMinSingleScore;
    const bool too_large = span >= options_.border_span && seen_well;
    const bool often =
        options_.border_members > 0 && static_cast<int>(spans.size()) >= options_.border_members;
    if (too_large || often) {
      group.reason = std::string(too_large ? "too large to keep the margin from"
                                           : "never within the margin from") +
                     " the image border, seen in " + std::to_string(spans.size()) + " frames";
      objects_.push_back(std::move(group));
      continue;
    }
    for (const int i : group.observations) {
      all_[static_cast<std::size_t>(i)].object = ObjectId();
      Reject(*all_[static_cast<std::size_t>(i)].segment, "touches border");
    }
  }
}

void Matcher::Finish(Association& association) {
  RecallOrphans();  // before objects give detections up: those found one
  MergeDuplicates(objects_, all_, rejections_);
  AdoptOrphans();
  StartObjectsAtBorder();
  MergeDuplicates(objects_, all_, rejections_);
  RejectNoise(objects_, all_, coarse_views_, camera_, options_, rejections_);
  for (ObjectHypothesis& object : objects_) {
    std::map<std::string, double> votes = ClassVotes(object, all_);
    association.tracks.push_back(
        {object.id, object.class_name, std::move(object.members), object.reason, std::move(votes)});
  }
  std::ranges::move(rejections_, std::back_inserter(association.rejections));
}

void Sort(Association& association) {
  std::ranges::sort(association.tracks, {}, &ObjectTrack::id);
  std::ranges::stable_sort(association.rejections, [](const Rejection& a, const Rejection& b) {
    return a.frame != b.frame ? a.frame < b.frame : a.detection < b.detection;
  });
}

}  // namespace

void Describe(OptionsVisitor& visitor, AssociateOptions& options) {
  visitor.Field("min_members",
                options.min_members,
                {1, 1000},
                "1",
                "objects with fewer detections and a low score are dropped");
  visitor.Field("border_span",
                options.border_span,
                {0, 2},
                "1",
                "share of the image a box at its border must span to start an object after all");
  visitor.Field(
      "border_members",
      options.border_members,
      {0, 10000},
      "1",
      "agreeing boxes at the border that start an object whatever their size; 0: none do");
}

Result<Association> Associate(const FrameSource& frames,
                              const Trajectory& trajectory,
                              std::span<const int> part_of_frame,
                              std::vector<Segment> segments,
                              const AssociateOptions& options,
                              Progress& progress) {
  std::map<FrameIdx, std::vector<Segment*>> segments_of;
  for (Segment& segment : segments) segments_of[segment.frame].push_back(&segment);
  const std::vector<std::pair<FrameIdx, std::vector<Segment*>>> by_frame(segments_of.begin(),
                                                                         segments_of.end());
  const auto is_known = [&](FrameIdx frame) {
    return frame.value >= 0 && frame.value < static_cast<int>(trajectory.frames.size());
  };
  Shared shared;
  std::map<int, Matcher> matchers;  // by part
  std::vector<Rejection> unknown;
  std::array<std::optional<FrameLook>, kLooksAhead> looks;
  const auto look = [&](std::size_t n) {
    const auto& [frame, of_frame] = by_frame[n];
    if (!is_known(frame)) return;
    looks[n % kLooksAhead] =
        LookAt(frames, frame, trajectory.at(frame).world_from_camera, of_frame);
  };
  const auto match = [&](std::size_t n) {
    if (progress.StopRequested()) return false;
    const auto& [frame, of_frame] = by_frame[n];
    if (!is_known(frame)) {
      for (const Segment* s : of_frame) unknown.push_back({s->detection, frame, "frame unknown"});
    } else {
      const int part = part_of_frame[static_cast<std::size_t>(frame.value)];
      Matcher& matcher =
          matchers.try_emplace(part, frames.camera(), trajectory, options, shared).first->second;
      matcher.AddFrame(frame, of_frame, *std::move(looks[n % kLooksAhead]));
    }
    progress.Report(n + 1, by_frame.size());
    return true;
  };
  ParallelAhead(by_frame.size(), kLooksAhead, look, match);
  if (progress.StopRequested()) return Interrupted();
  Association association;
  for (auto& [part, matcher] : matchers) matcher.Finish(association);
  Sort(association);
  association.rejections.insert(association.rejections.begin(), unknown.begin(), unknown.end());
  return association;
}

}  // namespace deepslam::associate
