// Which candidate is each object's shape, after what all its depth makes of the candidates has
// joined them.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "deepslam/core/result.h"
#include "deepslam/modelling/object_options.h"
#include "deepslam/propose/proposer.h"
#include "deepslam/scene/object_map.h"
#include "deepslam/scene/registration.h"
#include "deepslam/scene/shape_candidate.h"

namespace deepslam::modelling {

struct RegisteredCandidates {
  const Proposals& proposals;
  std::span<const CandidateRegistration> registrations;  // of all of them
  const propose::ShapePriors* priors = nullptr;          // none: no network's shape is refined
};

struct Selection {
  ObjectMap map;
  Proposals made;  // candidates added here, numbered behind the proposed, with their models
  std::vector<CandidateRegistration> made_registrations;  // and what replaces those of the proposed
  std::vector<std::string> applied;                       // of a person's choices
};

// Errors: a candidate without registration, a missing model, a choice that cannot be followed.
[[nodiscard]] Result<Selection> SelectObjects(const TrackedObjects& objects,
                                              const RegisteredCandidates& candidates,
                                              const ObjectSources& sources,
                                              const ObjectOptions& options);

}  // namespace deepslam::modelling
