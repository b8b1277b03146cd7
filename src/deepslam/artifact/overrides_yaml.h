// overrides.yaml: what a person corrects in a run; and overrides.json: what of it a stage applied.
//
//   version: 1
//   drop: [7]                                        # no object
//   merge: [[1, 4]]                                  # one object; the first keeps its id
//   split: [{object: 2, at_frames: [130]}]           # from that frame on another object
//   relabel: {5: table}
//   choose: {1: scopia__kids_desk_chair}             # a candidate's model, or its number
//   ground: {up_camera: [0, -1, 0], height_m: 1.35}  # seen from the first tracked camera
//
// Objects are named by id or as in the scene ("chair_04"), with the ids of a run without overrides.
// A name has to be that object's own, before or after its `relabel`.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "deepslam/core/ids.h"
#include "deepslam/core/result.h"
#include "deepslam/core/text_pieces.h"

namespace deepslam::artifact {

// A line of the file, for messages.
struct ObjectOverride {
  ObjectId object;
  int line = 0;
};
struct MergeOverride {
  ObjectId kept;
  std::vector<ObjectId> merged;
  int line = 0;
};
struct SplitOverride {
  ObjectId object;
  std::vector<FrameIdx> at_frames;  // ascending
  int line = 0;
};
struct TextOverride {
  ObjectId object;
  std::string text;  // class of `relabel`; model key or number of `choose`
  int line = 0;
};
// An object that was named by more than its id: "chair_04" is a chair, or the line is wrong.
struct NamedObject {
  ObjectId object;
  std::string class_name;
  int line = 0;
};
struct GroundHint {
  Eigen::Vector3d up_camera = Eigen::Vector3d(0, -1, 0);  // unit
  double height_m = 0;                                    // of the camera above the ground
};

struct Overrides {
  std::string file;  // for messages
  std::vector<ObjectOverride> drop;
  std::vector<MergeOverride> merge;
  std::vector<SplitOverride> split;
  std::vector<TextOverride> relabel;
  std::vector<TextOverride> choose;
  std::optional<GroundHint> ground;
  std::vector<NamedObject> named;          // in drop, merge, split, relabel
  std::vector<NamedObject> named_choices;  // in choose
};

// All faults at once (kInvalidConfig), each with its line: unknown keys with the known ones, values
// of the wrong kind, an object named twice where that has no meaning.
[[nodiscard]] Result<Overrides> DecodeOverrides(std::string_view text, std::string_view name);

// The names to be checked: against the tracks as they were found, and against those that all
// corrections were applied to. The old name of a relabelled object is known to the former alone, so
// that it is checked there in `choose` as well; the new one is right by itself and in neither.
[[nodiscard]] std::vector<NamedObject> NamesOfTracks(const Overrides& overrides);
[[nodiscard]] std::vector<NamedObject> NamesOfChoices(const Overrides& overrides);

// Canonical texts of what concerns the tracks, the choice of shapes and the ground, for stage keys:
// equal whenever the meaning is, whatever comments and order of keys; a name that has to be checked
// is part of it. Empty = nothing.
[[nodiscard]] std::string TrackOverridesText(const Overrides& overrides);
[[nodiscard]] std::string ChoiceOverridesText(const Overrides& overrides);
[[nodiscard]] std::string GroundOverridesText(const Overrides& overrides);

// overrides.json: one sentence per override that a stage applied.
[[nodiscard]] Result<std::string> EncodeApplied(const std::vector<std::string>& applied,
                                                std::string_view name);
[[nodiscard]] Result<std::vector<std::string>> DecodeApplied(TextSource text,
                                                             std::string_view name);

}  // namespace deepslam::artifact
