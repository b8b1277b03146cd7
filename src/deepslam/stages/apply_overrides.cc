#include "deepslam/stages/apply_overrides.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string_view>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace deepslam::stages {
namespace {

using artifact::Overrides;

constexpr double kHintAngleRad = 10 * std::numbers::pi / 180;  // a person's guess of upright
constexpr double kHintHeightM = 0.15;                          // levels closer than this are one

std::string Place(const Overrides& overrides, int line) {
  return fmt::format("{}:{}", overrides.file, line);
}

template <typename Track>
Track* Find(std::span<Track> tracks, ObjectId id) {
  const auto found = std::find_if(
      tracks.begin(), tracks.end(), [&](const ObjectTrack& track) { return track.id == id; });
  return found == tracks.end() ? nullptr : &*found;
}

ObjectTrack* Find(Association& association, ObjectId id) {
  return Find(std::span(association.tracks), id);
}

template <typename Items, typename Name>
std::string Known(const Items& items, Name name) {
  std::vector<std::string> names;
  for (const auto& item : items) names.push_back(name(item));
  return names.empty() ? "none" : fmt::format("{}", fmt::join(names, ", "));
}

Error UnknownObject(const Overrides& overrides,
                    int line,
                    std::string_view object,
                    std::span<const ObjectTrack> tracks) {
  return InvalidConfig(fmt::format("{}: there is no object {}; known are {}",
                                   Place(overrides, line),
                                   object,
                                   Known(tracks, [](const ObjectTrack& track) {
                                     return fmt::format(
                                         "{} ({})", track.id.value, track.class_name);
                                   })));
}

// An object that is there under another name may not be the one that was meant.
Status CheckNames(const Overrides& overrides,
                  const std::vector<artifact::NamedObject>& names,
                  std::span<const ObjectTrack> tracks) {
  for (const artifact::NamedObject& name : names) {
    const ObjectTrack* track = Find(tracks, name.object);
    if (track == nullptr || track->class_name == name.class_name) continue;
    return UnknownObject(overrides,
                         name.line,
                         fmt::format("{}_{:02d}, object {} is called {}_{:02d} (write {} if it is "
                                     "meant)",
                                     name.class_name,
                                     name.object.value,
                                     name.object.value,
                                     track->class_name,
                                     name.object.value,
                                     name.object.value),
                         tracks);
  }
  return Ok();
}

Status Split(const Overrides& overrides,
             const artifact::SplitOverride& split,
             Association& association,
             std::vector<std::string>& applied) {
  ObjectId rest = split.object;
  for (const FrameIdx at : split.at_frames) {
    ObjectTrack* track = Find(association, rest);
    const auto begin = std::find_if(track->members.begin(),
                                    track->members.end(),
                                    [&](const TrackMember& member) { return member.frame >= at; });
    if (begin == track->members.begin() || begin == track->members.end()) {
      return InvalidConfig(fmt::format(
          "{}: object {} has detections on one side of frame {} only; it was seen in {}",
          Place(overrides, split.line),
          split.object.value,
          at.value,
          Known(track->members,
                [](const TrackMember& m) { return std::to_string(m.frame.value); })));
    }
    ObjectTrack part = *track;
    part.id = ObjectId{0};
    for (const ObjectTrack& other : association.tracks) {
      part.id.value = std::max(part.id.value, other.id.value + 1);
    }
    part.members.assign(begin, track->members.end());
    part.reason = fmt::format("split from object {} by hand", split.object.value);
    track->members.erase(begin, track->members.end());
    applied.push_back(fmt::format("object {} was split at frame {}: from there on it is object {}",
                                  split.object.value,
                                  at.value,
                                  part.id.value));
    rest = part.id;
    association.tracks.push_back(std::move(part));
  }
  return Ok();
}

void Merge(ObjectId kept, ObjectId merged, Association& association) {
  ObjectTrack* into = Find(association, kept);
  for (TrackMember member : Find(association, merged)->members) {
    member.how = "merge";
    into->members.push_back(std::move(member));
  }
  std::stable_sort(into->members.begin(),
                   into->members.end(),
                   [](const TrackMember& a, const TrackMember& b) { return a.frame < b.frame; });
  std::erase_if(association.tracks, [&](const ObjectTrack& track) { return track.id == merged; });
}

void Drop(ObjectId object, Association& association) {
  for (const TrackMember& member : Find(association, object)->members) {
    association.rejections.push_back(
        {member.detection, member.frame, fmt::format("object {} dropped by hand", object.value)});
  }
  std::erase_if(association.tracks, [&](const ObjectTrack& track) { return track.id == object; });
}

// Before anything is changed: every object named is there, under that name.
Status CheckObjects(const Overrides& overrides, Association& association) {
  const auto check = [&](ObjectId object, int line) -> Status {
    if (Find(association, object) != nullptr) return Ok();
    return UnknownObject(overrides, line, std::to_string(object.value), association.tracks);
  };
  std::vector<std::pair<ObjectId, int>> named;
  for (const auto& split : overrides.split) named.emplace_back(split.object, split.line);
  for (const auto& merge : overrides.merge) {
    named.emplace_back(merge.kept, merge.line);
    for (const ObjectId object : merge.merged) named.emplace_back(object, merge.line);
  }
  for (const auto& relabel : overrides.relabel) named.emplace_back(relabel.object, relabel.line);
  for (const auto& drop : overrides.drop) named.emplace_back(drop.object, drop.line);
  for (const auto& [object, line] : named) {
    if (Status status = check(object, line); !status.ok()) return status;
  }
  return CheckNames(overrides, artifact::NamesOfTracks(overrides), association.tracks);
}

Status Relabel(const Overrides& overrides,
               const ClassTable& classes,
               Association& association,
               std::vector<std::string>& applied) {
  for (const artifact::TextOverride& relabel : overrides.relabel) {
    if (classes.Find(relabel.text) == nullptr) {
      return InvalidConfig(fmt::format("{}: there is no class \"{}\"; known are {}",
                                       Place(overrides, relabel.line),
                                       relabel.text,
                                       Known(classes.classes, [](const ObjectClass& object_class) {
                                         return object_class.name;
                                       })));
    }
    ObjectTrack* track = Find(association, relabel.object);
    if (track == nullptr) continue;  // merged away
    applied.push_back(fmt::format(
        "object {} is a {} instead of a {}", track->id.value, relabel.text, track->class_name));
    track->class_name = relabel.text;
  }
  return Ok();
}

}  // namespace

Result<std::vector<std::string>> ApplyToTracks(const Overrides& overrides,
                                               const ClassTable& classes,
                                               Association& association) {
  std::vector<std::string> applied;
  if (Status status = CheckObjects(overrides, association); !status.ok()) return status.error();
  for (const auto& split : overrides.split) {
    if (Status status = Split(overrides, split, association, applied); !status.ok())
      return status.error();
  }
  for (const auto& merge : overrides.merge) {
    for (const ObjectId object : merge.merged) {
      Merge(merge.kept, object, association);
      applied.push_back(
          fmt::format("object {} is part of object {}", object.value, merge.kept.value));
    }
  }
  if (Status status = Relabel(overrides, classes, association, applied); !status.ok())
    return status.error();
  for (const auto& drop : overrides.drop) {
    if (Find(association, drop.object) == nullptr) {
      return InvalidConfig(fmt::format("{}: object {} is merged into another and dropped as well",
                                       Place(overrides, drop.line),
                                       drop.object.value));
    }
    Drop(drop.object, association);
    applied.push_back(fmt::format("object {} was dropped", drop.object.value));
  }
  std::stable_sort(association.tracks.begin(),
                   association.tracks.end(),
                   [](const ObjectTrack& a, const ObjectTrack& b) { return a.id < b.id; });
  return applied;
}

std::vector<std::string> ApplyToGround(const Overrides& overrides,
                                       const Trajectory& trajectory,
                                       Ground& ground) {
  if (!overrides.ground) return {};
  // The world is the first camera's, so the hint is a plane of the world as it stands.
  const Plane hint{overrides.ground->up_camera, overrides.ground->height_m};
  const auto agrees = [&](const Plane& plane_world) {
    const double cosine = std::clamp(plane_world.normal.dot(hint.normal), -1.0, 1.0);
    return std::acos(cosine) < kHintAngleRad && std::abs(plane_world.d_m - hint.d_m) < kHintHeightM;
  };
  // What was not measured against the first camera keeps its own ground.
  const std::size_t before = ground.observations.size();
  std::erase_if(ground.observations, [&](const GroundObservation& observation) {
    if (ApartAt(ground, observation.keyframe) != nullptr) return false;
    const Pose3& world_from_camera = trajectory.at(observation.keyframe).world_from_camera;
    return !agrees(Transformed(world_from_camera, observation.plane_camera));
  });
  const std::size_t removed = before - ground.observations.size();
  if (ground.plane_world && agrees(*ground.plane_world)) {
    return {fmt::format(
        "the ground found agrees with the hint; {} of {} observations left out", removed, before)};
  }
  ground.plane_world = hint;
  return {
      fmt::format("the hint is the ground, {:.2f} m below the first camera; {} of {} "
                  "observations left out",
                  hint.d_m,
                  removed,
                  before)};
}

Status CheckChoices(const Overrides& overrides, std::span<const ObjectTrack> tracks) {
  for (const artifact::TextOverride& choice : overrides.choose) {
    if (Find(tracks, choice.object) != nullptr) continue;
    return UnknownObject(overrides,
                         choice.line,
                         fmt::format("{} to choose a candidate for", choice.object.value),
                         tracks);
  }
  return CheckNames(overrides, artifact::NamesOfChoices(overrides), tracks);
}

Result<CandidateId> ChosenByHand(const Overrides& overrides,
                                 ObjectId object,
                                 std::span<const ShapeCandidate> candidates) {
  for (const artifact::TextOverride& choice : overrides.choose) {
    if (choice.object != object) continue;
    for (const ShapeCandidate& candidate : candidates) {
      if (candidate.model == choice.text || std::to_string(candidate.id.value) == choice.text)
        return candidate.id;
    }
    return InvalidConfig(fmt::format("{}: object {} has no candidate \"{}\"; known are {}",
                                     Place(overrides, choice.line),
                                     object.value,
                                     choice.text,
                                     Known(candidates, [](const ShapeCandidate& candidate) {
                                       return fmt::format(
                                           "{} ({})", candidate.id.value, candidate.model);
                                     })));
  }
  return CandidateId{};
}

}  // namespace deepslam::stages
