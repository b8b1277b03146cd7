// Where every candidate stands in every view of its object.
#pragma once

#include <vector>

#include "deepslam/core/result.h"
#include "deepslam/modelling/object_options.h"
#include "deepslam/scene/registration.h"
#include "deepslam/scene/shape_candidate.h"

namespace deepslam::modelling {

// One registration per candidate, in the order of their ids. The error of a model that is missing
// names it.
[[nodiscard]] Result<std::vector<CandidateRegistration>> RegisterObjects(
    const TrackedObjects& objects,
    const Proposals& proposals,
    const ObjectSources& sources,
    const ObjectOptions& options);

}  // namespace deepslam::modelling
