// What a person corrects in a run. Objects have the ids of a run without corrections.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "deepslam/core/ids.h"

namespace deepslam {

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

// The names to be checked: against the tracks as they were found, and against those that all
// corrections were applied to. The old name of a relabelled object is known to the former alone, so
// that it is checked there in `choose` as well; the new one is right by itself and in neither.
[[nodiscard]] std::vector<NamedObject> NamesOfTracks(const Overrides& overrides);
[[nodiscard]] std::vector<NamedObject> NamesOfChoices(const Overrides& overrides);

}  // namespace deepslam
