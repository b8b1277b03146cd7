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

#include <string>
#include <string_view>
#include <vector>

#include "deepslam/core/result.h"
#include "deepslam/core/text_pieces.h"
#include "deepslam/scene/overrides.h"

namespace deepslam::artifact {

// All faults at once (kInvalidConfig), each with its line: unknown keys with the known ones, values
// of the wrong kind, an object named twice where that has no meaning.
[[nodiscard]] Result<Overrides> DecodeOverrides(std::string_view text, std::string_view name);

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
