// Whole shapes proposed for objects. Sources plug in equally: what matters of one is among its
// traits (candidate_source.h).
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "deepslam/core/ids.h"
#include "deepslam/geometry/similarity.h"
#include "deepslam/scene/candidate_source.h"
#include "deepslam/scene/voxel_grid.h"

namespace deepslam {

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
  // Where the shape was measured, in the world of the path that its source had: the registration
  // starts there. None for shapes that know nothing of where their object stands.
  std::optional<Similarity3> world_from_object;
};

struct Proposals {
  std::vector<ShapeCandidate> candidates;   // ascending id
  std::map<std::string, VoxelGrid> models;  // by key; several candidates may share one
  // Objects for which a source had nothing, with the reason ("class furniture has no prior").
  std::vector<std::string> notes;
};

}  // namespace deepslam
