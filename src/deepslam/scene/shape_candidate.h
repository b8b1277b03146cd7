// Whole shapes proposed for objects. Sources plug in equally; selection does not care where a
// candidate came from.
#pragma once

#include <array>
#include <cstddef>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "deepslam/core/ids.h"
#include "deepslam/scene/voxel_grid.h"

namespace deepslam {

enum class CandidateSource {
  kNetwork,     // class-specific network, from one view
  kMeanLatent,  // decoder at the mean latent over an object's views
  kRetrieval,   // CAD model of the library
  kFused,       // the object's own fused measurement
  kRefined,     // a network's shape that followed all depth of its object
  kCompleted,   // a whole model, or a refined shape, that took over what was measured
};

// In files.
inline constexpr std::array<std::string_view, 6> kCandidateSourceNames = {
    "network", "mean_latent", "retrieval", "fused", "refined", "completed"};
[[nodiscard]] constexpr std::string_view NameOf(CandidateSource source) {
  return kCandidateSourceNames[static_cast<std::size_t>(source)];
}

// Made in selection of what was proposed.
[[nodiscard]] constexpr bool IsRefined(CandidateSource source) {
  return source == CandidateSource::kRefined || source == CandidateSource::kCompleted;
}

struct ShapeCandidate {
  CandidateId id;
  ObjectId object;
  CandidateSource source = CandidateSource::kRetrieval;
  DetectionId view;           // the view that proposed it; invalid where all views together did
  std::string model;          // key into Proposals::models and file stem of models/<model>.binvox
  double proposal_score = 0;  // the source's own opinion, [0, 1]; comparable within one source only
  // Real longest side of the object, metres, as the source believes; bounds for the registration's
  // scale.
  double size_m = 0;  // 0 = unknown
  double min_size_m = 0;
  double max_size_m = 0;
  // Network sources and what was refined of them; empty otherwise, and where the model is what the
  // latents give in other proportions.
  std::vector<float> latents;
  std::string library_id;  // retrieval: the library's id of the model
  std::string credit;      // retrieval: creator and licence, to travel into the scene
  // Retrieval: the model is the library's, by shape::StretchGrid with these factors; ones = as it
  // is.
  Eigen::Vector3d stretch = Eigen::Vector3d::Ones();
};

struct Proposals {
  std::vector<ShapeCandidate> candidates;   // ascending id
  std::map<std::string, VoxelGrid> models;  // by key; several candidates may share one
  // Objects for which a source had nothing, with the reason ("class furniture has no prior").
  std::vector<std::string> notes;
};

}  // namespace deepslam
