#include "deepslam/overrides/apply_to_tracks.h"

#include <algorithm>
#include <span>
#include <utility>

#include <fmt/format.h>

#include "deepslam/overrides/known_objects.h"

namespace deepslam::overrides {
namespace {

ObjectTrack* TrackOf(Association& association, ObjectId id) {
  return Find(std::span(association.tracks), id);
}

Status Split(const Overrides& overrides,
             const SplitOverride& split,
             Association& association,
             std::vector<std::string>& applied) {
  ObjectId rest = split.object;
  for (const FrameIdx at : split.at_frames) {
    ObjectTrack* track = TrackOf(association, rest);
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
  ObjectTrack* into = TrackOf(association, kept);
  for (TrackMember member : TrackOf(association, merged)->members) {
    member.how = "merge";
    into->members.push_back(std::move(member));
  }
  std::stable_sort(into->members.begin(),
                   into->members.end(),
                   [](const TrackMember& a, const TrackMember& b) { return a.frame < b.frame; });
  std::erase_if(association.tracks, [&](const ObjectTrack& track) { return track.id == merged; });
}

void Drop(ObjectId object, Association& association) {
  for (const TrackMember& member : TrackOf(association, object)->members) {
    association.rejections.push_back(
        {member.detection, member.frame, fmt::format("object {} dropped by hand", object.value)});
  }
  std::erase_if(association.tracks, [&](const ObjectTrack& track) { return track.id == object; });
}

// Before anything is changed: every object named is there, under that name.
Status CheckObjects(const Overrides& overrides, Association& association) {
  const auto check = [&](ObjectId object, int line) -> Status {
    if (TrackOf(association, object) != nullptr) return Ok();
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
  return CheckNames(overrides, NamesOfTracks(overrides), association.tracks);
}

Status Relabel(const Overrides& overrides,
               const ClassTable& classes,
               Association& association,
               std::vector<std::string>& applied) {
  for (const TextOverride& relabel : overrides.relabel) {
    if (classes.Find(relabel.text) == nullptr) {
      return InvalidConfig(fmt::format("{}: there is no class \"{}\"; known are {}",
                                       Place(overrides, relabel.line),
                                       relabel.text,
                                       Known(classes.classes, [](const ObjectClass& object_class) {
                                         return object_class.name;
                                       })));
    }
    ObjectTrack* track = TrackOf(association, relabel.object);
    if (track == nullptr) continue;  // merged away
    applied.push_back(fmt::format(
        "object {} is a {} instead of a {}", track->id.value, relabel.text, track->class_name));
    track->class_name = relabel.text;
    track->class_votes = {{relabel.text, 1.0}};  // a person's word ends the vote
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
    if (TrackOf(association, drop.object) == nullptr) {
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

}  // namespace deepslam::overrides
