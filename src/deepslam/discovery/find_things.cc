#include "deepslam/discovery/find_things.h"

#include <algorithm>
#include <map>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "deepslam/discovery/best_views.h"
#include "deepslam/discovery/cut_silhouettes.h"
#include "deepslam/discovery/frame_claims.h"

namespace deepslam::discovery {
namespace {

using instances::Instance;
using instances::Instances;
using instances::Silhouette;
using instances::Superpoints;
using instances::SurfaceElements;

// Neighbours on a surface whose elements lie a voxel apart, also across its edges and diagonals.
constexpr double kNeighbourVoxels = 1.9;
// Of a silhouette that no detection shows: less than any detection that is kept by default.
constexpr double kUndetectedScore = 0.25;
// What nothing names and fewer frames show stands at the rim of what was seen: too little of it for
// a shape. Frames whose border cuts it count half: registered depth ends 2 % of a picture's width
// before its border.
constexpr double kMinViewsOfUnnamed = 4;
constexpr double kCutView = 0.5;    // of a view
constexpr double kRimShare = 0.03;  // of the longer side
// Rejected things of so much surface are told of, and long ones of less: of a chair that is seen
// from behind alone there is little more than the upper rail of its back.
constexpr double kLargeM2 = 0.15;
constexpr double kLongM = 0.4;           // the longest side, or the height, of a long one
constexpr double kLargeOfLongM2 = 0.06;  // a rail of 0.4 m that is 0.15 m high

// Which thing each detection of a frame is of: the one that most of what it claims belongs to.
std::vector<int> ThingsOfDetections(const instances::FrameClaims& claims,
                                    std::span<const Detection> detections,
                                    const Superpoints& superpoints,
                                    const std::vector<int>& thing_of_superpoint) {
  std::vector<std::map<int, int>> num_claimed(detections.size());
  for (std::size_t k = 0; k < claims.superpoints.size(); ++k) {
    if (claims.claimed_by[k] < 0) continue;
    const auto superpoint = static_cast<std::size_t>(claims.superpoints[k]);
    num_claimed[static_cast<std::size_t>(claims.claimed_by[k])][thing_of_superpoint[superpoint]] +=
        superpoints.num_elements[superpoint];
  }
  std::vector<int> things;
  for (const std::map<int, int>& claimed : num_claimed) {
    const auto most = std::ranges::max_element(claimed, {}, &std::pair<const int, int>::second);
    things.push_back(most == claimed.end() ? -1 : most->first);
  }
  return things;
}

// The same of a frame of the capture; none where no detector looked.
std::vector<int> ThingsDetectedIn(FrameIdx frame,
                                  const ThingInputs& inputs,
                                  const Claims& claims,
                                  const Superpoints& superpoints,
                                  const std::vector<int>& thing_of_superpoint) {
  const std::span<const Detection> detections = DetectionsOf(inputs, frame);
  if (detections.empty()) return {};
  const auto at = std::ranges::lower_bound(inputs.looked_at, frame);
  if (at == inputs.looked_at.end() || *at != frame) return std::vector(detections.size(), -1);
  const auto n = static_cast<std::size_t>(at - inputs.looked_at.begin());
  return ThingsOfDetections(claims.frames[n], detections, superpoints, thing_of_superpoint);
}

std::vector<int> ThingsOfSuperpoints(const Superpoints& superpoints, const Instances& found) {
  std::vector<int> things(static_cast<std::size_t>(superpoints.count()), -1);
  for (std::size_t i = 0; i < superpoints.of_element.size(); ++i) {
    if (superpoints.of_element[i] >= 0)
      things[static_cast<std::size_t>(superpoints.of_element[i])] = found.of_element[i];
  }
  return things;
}

bool IsWorthTelling(const Instance& instance, double surface_m2) {
  const instances::UprightBox& box = instance.box_level;
  const bool is_long = std::max(box.long_side_m(), box.height_m()) >= kLongM;
  return instance.is_named || surface_m2 >= (is_long ? kLargeOfLongM2 : kLargeM2);
}

bool IsCut(const Box2& box_px, const PinholeCamera& camera) {
  const double rim_px = kRimShare * std::max(camera.width, camera.height);
  return std::min(box_px.u_min, box_px.v_min) < rim_px || box_px.u_max > camera.width - rim_px ||
         box_px.v_max > camera.height - rim_px;
}

Segment SegmentOf(const Silhouette& silhouette,
                  const Instance& instance,
                  FrameIdx frame,
                  const Detection* detection) {
  Segment segment;
  segment.frame = frame;
  segment.class_name = instance.class_name;
  segment.score = detection != nullptr ? detection->score : kUndetectedScore;
  segment.source = detection != nullptr ? detection->source : DetectionSource::kCluster;
  segment.box_px = silhouette.box_px;
  segment.mask = silhouette.mask;
  segment.num_points = silhouette.num_points;
  segment.extent_camera = silhouette.extent_camera;
  segment.depth_support = silhouette.num_points / silhouette.box_px.area_px();
  segment.touches_border = silhouette.touches_border;
  segment.usable = true;
  return segment;
}

// The tracks of a capture while its frames are gone through.
class Tracks {
 public:
  Tracks(const ThingInputs& inputs, const Instances& found) : inputs_(inputs), found_(found) {
    next_id_ = inputs.next_detection_id;
    members_.resize(found.instances.size());
    num_views_.resize(found.instances.size(), 0);
    votes_.resize(found.instances.size());
  }

  // `thing_of_detection`: of the detections of the frame.
  void Add(FrameIdx frame,
           std::span<const Silhouette> silhouettes,
           const std::vector<int>& thing_of_detection) {
    const std::span<const Detection> detections = DetectionsOf(inputs_, frame);
    std::vector<bool> is_used(detections.size(), false);
    for (const Silhouette& silhouette : silhouettes) {
      const auto thing = static_cast<std::size_t>(silhouette.instance);
      const std::optional<std::size_t> own =
          BestOf(detections, thing_of_detection, silhouette.instance);
      if (own) is_used[*own] = true;
      Segment segment =
          SegmentOf(silhouette, found_.instances[thing], frame, own ? &detections[*own] : nullptr);
      segment.detection = own ? detections[*own].id : DetectionId{next_id_++};
      members_[thing].push_back({segment.detection, segment.frame, 0, 0, "surface"});
      num_views_[thing] += IsCut(segment.box_px, inputs_.frames.camera()) ? kCutView : 1;
      segments_.push_back(std::move(segment));
    }
    for (std::size_t d = 0; d < detections.size(); ++d) {
      if (!is_used[d]) Reject(detections[d], thing_of_detection[d]);
    }
    Count(detections, thing_of_detection);
  }

  // The detections of a frame without silhouettes: votes alone.
  void AddVotes(FrameIdx frame, const std::vector<int>& thing_of_detection) {
    const std::span<const Detection> detections = DetectionsOf(inputs_, frame);
    for (std::size_t d = 0; d < detections.size(); ++d) {
      const int thing = thing_of_detection[d];
      if (thing < 0 || !found_.instances[static_cast<std::size_t>(thing)].rejection.empty())
        Reject(detections[d], thing);
    }
    Count(detections, thing_of_detection);
  }

  // `best`: where each thing shows best.
  [[nodiscard]] FoundThings Take(std::span<const Look> best) && {
    FoundThings found;
    found.segments = std::move(segments_);
    found.association.rejections = std::move(rejections_);
    int next_object = 0;
    for (std::size_t thing = 0; thing < members_.size(); ++thing) {
      const Instance& instance = found_.instances[thing];
      const double voxel_m = inputs_.surface.voxel_m;
      const double surface_m2 = static_cast<double>(instance.elements.size()) * voxel_m * voxel_m;
      const instances::UprightBox& box = instance.box_level;
      const std::string what = fmt::format("{:.2f} x {:.2f} x {:.2f} m, {:.1f} m2 seen",
                                           box.length_m,
                                           box.width_m,
                                           box.height_m(),
                                           surface_m2);
      const std::string why = WhyNot(instance, members_[thing].size(), num_views_[thing]);
      if (!why.empty()) {
        if (IsWorthTelling(instance, surface_m2))
          found.association.not_mapped.push_back(
              {fmt::format("{} at {:.2f}, {:.2f} ({}): {}",
                           instance.class_name.empty() ? "thing" : instance.class_name,
                           box.centre_m.x(),
                           box.centre_m.y(),
                           what,
                           why),
               thing < best.size() ? best[thing].seen : SeenIn()});
        continue;
      }
      ObjectTrack track;
      track.id = ObjectId{next_object++};
      track.class_name = instance.class_name;
      track.members = std::move(members_[thing]);
      track.reason = what + (instance.is_named ? Votes(instance) : "; no detection names it");
      track.class_votes = std::move(votes_[thing]);
      if (instance.is_named) track.class_votes.try_emplace(instance.class_name, 0);
      found.association.tracks.push_back(std::move(track));
    }
    return found;
  }

 private:
  // The best detection of that thing.
  static std::optional<std::size_t> BestOf(std::span<const Detection> detections,
                                           const std::vector<int>& thing_of_detection,
                                           int thing) {
    std::optional<std::size_t> best;
    for (std::size_t d = 0; d < detections.size(); ++d) {
      if (thing_of_detection[d] == thing &&
          (!best || detections[d].score > detections[*best].score))
        best = d;
    }
    return best;
  }

  void Count(std::span<const Detection> detections, const std::vector<int>& thing_of_detection) {
    for (std::size_t d = 0; d < detections.size(); ++d) {
      if (thing_of_detection[d] < 0 || detections[d].source == DetectionSource::kCluster) continue;
      votes_[static_cast<std::size_t>(thing_of_detection[d])][detections[d].class_name] +=
          detections[d].score;
    }
  }

  void Reject(const Detection& detection, int thing) {
    std::string reason = "no surface of a thing lies in it";
    if (thing >= 0) {
      const std::string& why = found_.instances[static_cast<std::size_t>(thing)].rejection;
      reason = why.empty() ? "another detection of the frame is of the same thing, or it is "
                             "hardly visible"
                           : why;
    }
    rejections_.push_back({detection.id, detection.frame, reason});
  }

  // Why it is no object of the map; empty: it is one.
  static std::string WhyNot(const Instance& instance, std::size_t num_frames, double num_views) {
    if (!instance.rejection.empty()) return instance.rejection;
    if (num_frames == 0) return "no frame shows enough of it";
    if (!instance.is_named && num_views < kMinViewsOfUnnamed)
      return fmt::format("only {} frames show enough of it, and no detection names it", num_frames);
    return {};
  }

  static std::string Votes(const Instance& instance) {
    std::string text = "; votes:";
    for (const auto& [name, share] : instance.class_shares)
      text += fmt::format(" {} {:.2f}", name, share);
    return text;
  }

  const ThingInputs& inputs_;
  const Instances& found_;
  int next_id_ = 0;
  std::vector<std::vector<TrackMember>> members_;     // of each instance
  std::vector<double> num_views_;                     // likewise, those that it is cut in half
  std::vector<std::map<std::string, double>> votes_;  // of each instance, by class
  std::vector<Segment> segments_;
  std::vector<Rejection> rejections_;
};

void AddFramesThatVote(const ThingInputs& inputs,
                       const Claims& claims,
                       const Superpoints& superpoints,
                       const std::vector<int>& thing_of_superpoint,
                       Tracks& tracks) {
  for (const FrameIdx frame : inputs.looked_at) {
    if (std::ranges::binary_search(inputs.wanted, frame)) continue;
    tracks.AddVotes(frame,
                    ThingsDetectedIn(frame, inputs, claims, superpoints, thing_of_superpoint));
  }
}

// What a frame shows.
struct Looked {
  std::vector<int> thing_of_detection;
  std::vector<Silhouette> silhouettes;
  std::vector<Look> looks;
};

// What masks show of things that may have slim parts. Closed ones have none that the surface of the
// capture would lose, and masks of beds and sofas hold what lies on them.
std::vector<instances::ShownInstance> ShownByMasks(std::span<const Detection> detections,
                                                   const std::vector<int>& thing_of_detection,
                                                   const Instances& found,
                                                   const ClassTable& classes) {
  std::vector<instances::ShownInstance> shown;
  for (std::size_t d = 0; d < detections.size(); ++d) {
    const int thing = thing_of_detection[d];
    if (thing < 0 || detections[d].mask.empty()) continue;
    const Instance& instance = found.instances[static_cast<std::size_t>(thing)];
    if (!classes.TraitsOf(instance.class_name).solid_inside)
      shown.push_back({thing, &detections[d].mask});
  }
  return shown;
}

}  // namespace

void Describe(OptionsVisitor& visitor, ThingOptions& options) {
  instances::Describe(visitor, options.instances);
}

Result<FoundThings> FindThings(const ThingInputs& inputs,
                               const ThingOptions& options,
                               Progress& progress) {
  const SurfaceElements elements(
      inputs.surface.mesh.vertices, inputs.surface.normals, inputs.surface.voxel_m);
  const std::vector<char> is_structure =
      instances::StructureElements(elements, inputs.layout, options.structure);
  const std::vector<instances::ElementPair> pairs =
      elements.PairsWithin(kNeighbourVoxels * elements.voxel_m());
  const Superpoints superpoints =
      instances::MakeSuperpoints(elements, is_structure, pairs, options.instances.superpoints);
  Result<Claims> claims =
      CollectClaims(inputs, elements, superpoints, options.instances.votes, progress);
  if (!claims.ok()) return claims.error();
  const Instances found = instances::FindInstances(elements,
                                                   superpoints,
                                                   pairs,
                                                   claims->votes,
                                                   inputs.layout.walls,
                                                   inputs.classes,
                                                   options.instances);
  const std::vector<int> thing_of_superpoint = ThingsOfSuperpoints(superpoints, found);

  const instances::NearestElements nearest(elements);
  const instances::DividedSurface divided{elements, nearest, found};
  Tracks tracks(inputs, found);
  std::vector<Look> best;
  const auto look = [&](std::size_t, const Frame& frame) {
    std::vector<int> thing_of_detection =
        ThingsDetectedIn(frame.idx, inputs, *claims, superpoints, thing_of_superpoint);
    const Pose3 level_from_camera = LevelFromCamera(inputs, frame.idx);
    std::vector<Silhouette> silhouettes = instances::FindSilhouettes(
        divided,
        ShownByMasks(DetectionsOf(inputs, frame.idx), thing_of_detection, found, inputs.classes),
        frame.depth_m,
        inputs.frames.camera(),
        level_from_camera,
        options.silhouettes);
    CutSilhouettes({frame, inputs.frames.camera(), level_from_camera, found.instances},
                   inputs.classes,
                   options.cut,
                   silhouettes);
    const instances::VotingView view{
        &frame.depth_m, inputs.frames.camera(), level_from_camera.Inverse(), {}};
    return Looked{std::move(thing_of_detection),
                  std::move(silhouettes),
                  LooksIn(frame.idx, view, elements, found, options.instances.votes)};
  };
  const auto add = [&](std::size_t n, Looked looked) {
    KeepBest(looked.looks, best);
    tracks.Add(inputs.wanted[n], looked.silhouettes, looked.thing_of_detection);
    progress.Report(n + 1, inputs.wanted.size());
  };
  const Status status =
      ForDepthFrames<Looked>(inputs.frames, inputs.wanted, false, progress, look, add);
  if (!status.ok()) return status.error();
  AddFramesThatVote(inputs, *claims, superpoints, thing_of_superpoint, tracks);
  return std::move(tracks).Take(best);
}

}  // namespace deepslam::discovery
