// The compact map of a finished map: what is enough to make its scene again, and where things are.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "deepslam/gltf/scene_writer.h"
#include "deepslam/presentation/finished_map.h"
#include "deepslam/scene/compact_map.h"
#include "deepslam/scene/run_verdict.h"
#include "deepslam/scene/shape_candidate.h"

namespace deepslam::presentation {

// How the shapes of the map are stored.
struct ModelCode {
  std::string voxels_sha256;  // of the model as binvox
  std::string voxel_code;     // shape::EncodeVoxels of it; needed where no library has the model
};
struct ShapeCodes {
  std::vector<ShapeCandidate> candidates;  // the chosen ones' latents and stretch are taken
  std::map<std::string, std::string> library_sha256;  // by id of the library's model
  std::map<std::string, ModelCode> models;            // by key of the model
};

// What is noted of the run.
struct MapNotes {
  RunIdentity run;
  RunVerdict verdict;
  std::map<std::string, std::string> mesh_options;  // those that differ from the defaults
};

// Rounded (map_rounding.h). `scene` is the one made of `finished`: its ground and its class colours
// are the map's. The shape of an object without a surface is left out, unless it is a library's.
[[nodiscard]] CompactMap MakeCompactMap(const FinishedMap& finished,
                                        const gltf::GltfScene& scene,
                                        const ShapeCodes& codes,
                                        const MapNotes& notes);

}  // namespace deepslam::presentation
